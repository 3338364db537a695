// Solid matter that melts, freezes or flows: what of each element is bound to a rest shape, and what flows.
// Dissertation 6.3 to 6.5.
#pragma once

#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "sim/bonds/stencil.h"
#include "sim/external/outside.h"
#include "sim/space/smoothing.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// Matter that melts, freezes or flows: Softening, one record a scene (sim/state/solids.h).

/// The one writer of a particle's phase and melt fraction b [1], and of its element's view of them.
void set_phase(Phase phase, Real b, Index particle, Index element, Particles& particles, Elements& elements);

/// Sets up the phases of a scene's elements; `any` tells whether there is something to do at all.
void make_phases(const scene::Scene& scene, const Smoothing& smoothing, Particles& particles, Solids& solids);

/// Gives elements to particles of solid material that have none, in the order of their ids: what emitters released.
void adopt_particles(const scene::Scene& scene, const Smoothing& smoothing, const Particles& particles, Solids& solids);

/// The melt fraction of every particle from its temperature, and what follows: an element that has become liquid leaves
/// the solids (its particle is then a liquid particle like any other), one that is no more comes back, free of strain,
/// bound to its present neighbours. A body that is solid throughout again gets a rest shape again: the present one,
/// with new rest neighbours, its elastic strain kept as m <- m + u, u <- 0, eps^p <- - Q (eps - eps^p) Q^T (6.15; Q the
/// rotation in J). `outside` and `last_dt` [s] turn velocities half a step back into those of now.
void change_phases(const scene::Scene& scene, const Outside& outside, double last_dt, Particles& particles,
                   Solids& solids);

/// Rest neighbours and moments of bodies that have frozen in another shape, from that shape: after reading a
/// checkpoint.
void find_refrozen_neighbours(Solids& solids);

/// Laws and stencils of all elements at `time` [s]. Requires the neighbours of now.
void prepare_stencils(const scene::Scene& scene, double time, const Smoothing& smoothing, const Particles& particles,
                      const NeighbourLists& neighbours, Solids& solids);

/// Adds the forces of D to those of R, which are in the bodies' frames. Returns D's largest squared stretch.
Real add_flow_forces(Solids& solids, StressScratch& scratch);

/// The drift of a sub-step [s], for D.
void drift_flow(double dt, Solids& solids);

/// After the sub-steps of dt [s]: D absorbs the deformation, its elastic strain turned along and partly forgotten by
/// creep; elements of R that are melting and have left their rest shape flow from now on.
///   e <- Q (e + eps) Q^T, eps = (J^T J - 1)/2, J = Q S;   where |e| > k_yield:  e <- (1 - min(dt k_creep, 1)) e
/// Requires solids.gradients of now.
void absorb_flow(double dt, Particles& particles, Solids& solids);

/// Pressure -tr(sigma)/3 of an element that flows [Pa]. Its density is the SPH sum's.
Real flow_pressure(const Solids& solids, std::size_t i);

/// The laws of the stencils R, as Elements::law numbers them.
const std::vector<StressLaw>& stencil_laws(const Solids& solids);

/// The law an element meets a wall with: what of it is not liquid. (Of the rest the liquid's wall pressure takes care.)
StressLaw contact_law(const Solids& solids, std::size_t i);

}  // namespace thixo
