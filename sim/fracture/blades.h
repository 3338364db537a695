// Blades cut sheets into solids as their edges move. Dissertation 5.6.6.
#pragma once

#include "pipeline/contract/scene.h"
#include "sim/bonds/weights.h"
#include "sim/fracture/tension.h"

namespace thixo {

/// Moves the edges of the matter's blades to `time` [s]. Each is carried into the material frame by the elements about
/// it. Where it has gone on by most of a row, a row of triangles joins the edge of before to that of now. They end a
/// little outside of the body, as sheets of other cracks do. A point of an edge that is drawn back leaves the row where
/// it is. An edge that has left the body begins a new cut the next time. Where a crack gapes it waits, and begins a new cut where
/// it meets the matter elsewhere. The fronts of a cut lie along the edge, and
/// along the ways of its ends: there the matter still holds. Stress does not move them. Requires the gradients of the
/// present time. Returns the longest next step [s]. In it no edge goes farther than half a row, or two supports far from
/// the matter.
double advance_blades(double time, const CrackedMatter& matter, const Solids& solids, std::vector<Blade>& blades,
                      Cracks& cracks);

/// Bonds that an edge has passed in the step of dt [s] to `time` [s]: they are to part. Only those count that are more
/// than twice as long as at rest. Strings of a few elements, from which the rest has drawn back, deform too unevenly for
/// a place in the material frame.
std::vector<WeakBond> severed_bonds(double time, double dt, const CrackedMatter& matter, const Solids& solids);

/// The scene's blades. Requires the breaking of their bodies. Throws InputError.
std::vector<Blade> make_blades(const scene::Scene& scene, const std::vector<Breaking>& breaking);

}  // namespace thixo
