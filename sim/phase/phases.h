// Solid matter that melts, freezes or flows: the part of each element bound to a rest shape, and the part that flows.
// Dissertation 6.3 to 6.5.
#pragma once

#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "sim/bonds/stencil.h"
#include "sim/external/outside.h"
#include "sim/solid/elasticity.h"
#include "sim/space/smoothing.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

// A scene with such matter has one record of it: Softening (sim/state/solids.h).

/// The one writer of a particle's phase and melt fraction b [1], and of its element's view of them.
void set_phase(Phase phase, Real b, Index particle, Index element, Particles& particles, Elements& elements);

/// Sets up the phases of a scene's elements. `Softening::any` tells whether any matter changes its phase.
void make_phases(const scene::Scene& scene, const Materials& materials, const Smoothing& smoothing,
                 Particles& particles, Solids& solids);

/// Gives elements to particles of solid material that have none, those of emitters, in the order of their ids.
void adopt_particles(const Materials& materials, const Smoothing& smoothing, const Particles& particles,
                     Solids& solids);

/// Computes the melt fraction of every particle from its temperature, and the phases that follow. An element that has
/// become liquid leaves the solids: its particle is then an ordinary liquid particle. One that is liquid no more
/// returns, free of strain, bound to its present neighbours. A body that is solid throughout again gets its present
/// shape as rest shape, with new rest neighbours. Its elastic strain stays (6.15; Q the rotation in J):
///     m <- m + u,   u <- 0,   eps^p <- - Q (eps - eps^p) Q^T
/// It has a frame of its own from then on. Cracks between elements that have both melted are gone. A fragment that is
/// liquid throughout is matter of its scene body again where that melts, too, once the surface of both is a liquid's.
/// `outside` and `last_dt` [s] turn velocities of half a step before into present ones. Returns 1 for each body that can
/// break and has lost or gained matter, or has a new rest shape: these must be bound anew (fracture/fragments.h). Empty
/// where there is none.
std::vector<std::uint8_t> change_phases(const Materials& materials, const Outside& outside, double last_dt,
                                        Particles& particles, Solids& solids);

/// Computes rest neighbours and moments of bodies that have frozen in another shape, from that shape. A checkpoint
/// needs it after reading. Bonds that persist keep their visibility.
void find_refrozen_neighbours(Solids& solids);

/// Computes laws and stencils of all elements at `time` [s]. Requires the present neighbours.
void prepare_stencils(const Materials& materials, double time, const Particles& particles,
                      const NeighbourLists& neighbours, Solids& solids);

/// Adds the forces of D to those of R, which are in the bodies' frames. Returns D's bounds.
StretchBounds add_flow_forces(Solids& solids, StressScratch& scratch);

/// Drifts the elements of D over a sub-step [s].
void drift_flow(double dt, Solids& solids);

/// After the sub-steps of dt [s], D absorbs the deformation. Its elastic strain turns with it, and creep forgets a
/// part:
///     e <- Q (e + eps) Q^T,   eps = (J^T J - 1)/2,   J = Q S
///     e <- (1 - min(dt k_creep, 1)) e      where |e| > k_yield
/// Elements of R that are melting and have left their rest shape flow from then on. Requires the present
/// solids.gradients.
void absorb_flow(double dt, Particles& particles, Solids& solids);

/// Pressure -tr(sigma)/3 of an element that flows [Pa]. Its density is that of the SPH sum.
Real flow_pressure(const Solids& solids, std::size_t i);

/// The laws of the stencils R, as Elements::law numbers them.
const std::vector<StressLaw>& stencil_laws(const Solids& solids);

/// The law of an element against a wall, for its part that is not liquid. The liquid's wall pressure acts on the other.
StressLaw contact_law(const Solids& solids, std::size_t i);

}  // namespace thixo
