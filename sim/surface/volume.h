// What the surface encloses, and how it is held to the particles' volume.
#pragma once

#include <vector>

#include "sim/surface/resample.h"
#include "sim/surface/surface.h"

namespace thixo {

/// The component of every surfel: the material of its body, so that liquids of one material join where they meet. A
/// body none of whose particles is left has component -1, which no particle is of.
std::vector<std::int32_t> components(const SurfaceState& surface, const Particles& particles);

/// Volume [m^3] that the surfels of each component enclose, up to the walls: the coat that reaches a little into them,
/// so that no film of air is seen there, does not count. `radius` r_s of a full surfel [m]. Throws ResourceError where
/// surfels are spread over millions of radii.
std::vector<double> volume_by_component(const SurfaceState& surface, const std::vector<std::int32_t>& component,
                                        const Walls& walls, Real radius);

/// The sum of that.
double surface_volume(const SurfaceState& surface, const Particles& particles, const Walls& walls, Real radius);

/// Volume of a particle's matter [m^3]: a liquid's at rest, for what it is compressed by is the solver's error; a
/// solid's as far as it is pressed together, or the surface of what has melted of the body would swell in its place.
/// Where a density is less than at rest, it is the free surface's, not the matter's.
double matter_volume(const Particles& particles, std::size_t j);

/// Brings `surface.lift` nearer to what makes each component enclose the volume of its particles:
///   lift <- lift + 0.7 (V_particles - V)/sum A_i g_i where that is at most 0.08 spacings; -0.6 to 0.3 spacings,
///   of a body of which less than a third of the surface has melted, three times that share of it
/// A_i is the area of a surfel, g_i the share of the lift that it has (SurfelNotes::give): all of it where matter has
/// come apart, in splashes and thin sheets, whose iso-surface encloses up to a third too much, a fifth elsewhere, where
/// it encloses a few per cent too little when it bends. As a step is small nobody sees the surface swell and shrink.
/// V_particles is the sum of matter_volume.
/// Where it was next to nothing the following three updates go without, if `calm`: the surface has hardly changed. A
/// volume that is off by more than 15 % is that of a surface which is open somewhere, and changes nothing.
void hold_volume(SurfaceState& surface, const Particles& particles, const SurfelNotes& notes, Real radius, Real spacing,
                 bool calm);

}  // namespace thixo
