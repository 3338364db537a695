// What is drawn where solids are in contact: one surface between them. Dissertation 5.8.
#pragma once

#include "sim/surface/embedded_surface.h"

namespace thixo {

/// Moves every surfel that has entered another body onto the contact surface, where
///   F(x) = (E_1 |psi_1(x) - x| - E_2 |psi_2(x) - x|)/(E_1 + E_2) = 0        |psi - x| the depths below both surfaces
/// on the segment to that body's surface; soft bodies give way to stiff ones, and both bodies' surfels meet on one
/// surface, with normals along +-grad F. Depths are the shapes' signed distances, in the displacement that the surfels
/// are drawn with. More than two bodies: one after another. Walls do not give way: what has entered one lies on it. The
/// simulation knows nothing of it: its surface stays as it is. In the dissertation the nodes are then spread evenly and
/// filled up; here every surfel stays itself, with its id and texture, and as surfaces that are pressed together do not
/// grow, no gap opens. After displace_embedded, which says in `source` whose surfels these are.
void draw_contacts(const EmbeddedSurface& embedded, const std::vector<Index>& source, const Walls& walls,
                   Solids& solids, SurfaceState& surface);

}  // namespace thixo
