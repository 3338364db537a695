// The drawn surface of solids in contact: one surface between them. Dissertation 5.8.
#pragma once

#include "sim/surface/embedded_surface.h"

namespace thixo {

/// Moves every surfel that has entered another body along the segment to that body's surface, onto the contact surface:
///     F(x) = (E_1 |psi_1(x) - x| - E_2 |psi_2(x) - x|)/(E_1 + E_2) = 0
/// |psi - x| are the depths below both surfaces. Soft bodies give way to stiff ones. Surfels of both bodies meet on one
/// surface, with normals along +-grad F. Depths are the shapes' signed distances, in the displacement with which the
/// surfels are drawn. More than two bodies are treated one after another. Walls do not give way: a surfel that has
/// entered one is moved onto it. The simulation is not affected. The dissertation then spreads the nodes evenly and
/// adds new ones. Here every surfel keeps its id and texture. Surfaces in contact do not grow, so that no gap opens. It
/// is called after displace_embedded, which writes in `source` whose surfels these are.
void draw_contacts(const EmbeddedSurface& embedded, const std::vector<Index>& source, const Walls& walls,
                   Solids& solids, SurfaceState& surface);

}  // namespace thixo
