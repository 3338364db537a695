// The volume that the surface encloses, and its control by the particles' volume.
#pragma once

#include <vector>

#include "sim/surface/resample.h"
#include "sim/surface/surface.h"

namespace thixo {

/// The component of every surfel: the material of its body, so that liquids of one material join where they meet. A
/// body without particles has component -1, which no particle has.
std::vector<std::int32_t> components(const SurfaceState& surface, const ParticleRows& particles);

/// Volume [m^3] that the surfels of each component enclose, up to the walls. The coat reaches a little into the walls,
/// so that no film of air is visible there; that part does not count. `radius` r_s of a full surfel [m]. Throws
/// ResourceError where surfels are spread over millions of radii.
std::vector<double> volume_by_component(const SurfaceState& surface, const std::vector<std::int32_t>& component,
                                        const Walls& walls, Real radius);

/// The sum of that.
double surface_volume(const SurfaceState& surface, const ParticleRows& particles, const Walls& walls, Real radius);

/// Volume of a particle's matter [m^3]. A liquid's is its rest volume: its compression is the solver's error. A solid's
/// is its compressed volume: otherwise the surface of the body's molten part would swell instead. A density below the
/// rest density belongs to the free surface, not to the matter.
double matter_volume(const Particles& particles, std::size_t j);

/// Moves `surface.lift` towards the value with which each component encloses the volume of its particles:
///     lift <- lift + 0.7 (V_particles - V)/sum A_i g_i      [m]
/// A step is at most 0.08 spacings, and lift lies between -0.6 and 0.3 spacings. Where less than a third of the surface
/// of a body has melted, these bounds are multiplied by three times the molten share. A_i is the area of a surfel, and
/// g_i the share of the lift that it has (SurfelNotes::lift_share). The share is one where matter has dispersed, in
/// splashes and thin sheets, whose iso-surface encloses up to a third too much. Elsewhere it is a fifth: there the
/// iso-surface encloses a few per cent too little when it bends. Steps are small, so that nobody sees the surface swell
/// and shrink. V_particles is the sum of matter_volume. With `steady`, the surface has hardly changed: after a very
/// small step the next three updates are skipped. A volume that is wrong by more than 15 % belongs to an open surface,
/// whose lift goes back to zero. Returns the relative error of the volume as it found it, over the other components:
///     sum |V - V_particles|/sum V_particles      [1]
/// It is 0 where it did not look.
double hold_volume(SurfaceState& surface, const ParticleRows& particles, const SurfelNotes& notes, Real radius,
                   Real spacing, bool steady);

}  // namespace thixo
