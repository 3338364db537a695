// Solid matter that melts, freezes or flows: what of each element is bound to a rest shape, and what flows.
// Dissertation 6.3 to 6.5.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "sim/particles.h"
#include "sim/smoothing.h"
#include "sim/solid/elasticity.h"

namespace thixo {

struct Solids;

/// What binds an element.
enum class Bond : std::uint8_t {
    rest,     // its rest shape, as far as it is solid; its present neighbours as far as it has melted
    flowing,  // its present neighbours alone: it has been liquid, or has left its rest shape
    none      // nothing: it is liquid, and the solids' steps leave it alone
};

/// The fastest rates of small motions of a body about its unstrained rest shape.
struct FastestRates {
    double stiffest = 0;  // omega^2 of vibrations [1/s^2]
    double damping = 0;   // of viscosity [1/s]
};

/// Of all elements of a scene in which solids melt, freeze or flow; empty elsewhere. Every element has two stencils,
/// each of which conserves momentum: R, of the rest neighbours, each bond weighed by 1 - max(b_i, b_j), and D, of the
/// present neighbours, whose rest shape absorbs the deformation of every step (6.15). b is the melt fraction; the
/// energy is
///   r U^R + (1 - r) U^D,   r = 1 - b where the rest shape binds, 0 elsewhere
struct Phases {
    bool any = false;
    // State.
    std::vector<Bond> bond;
    std::vector<std::uint8_t> refrozen;  // by SolidBody, 1: its rest shape is one it has frozen in
    // Of the present step.
    bool moves = true;                      // some element is not liquid
    bool freezes = false;                   // some element is bound to its present neighbours, if only in part
    bool flows = false;                     // D has elements
    std::vector<Real> melt;                 // b [1]
    std::vector<StressLaw> whole;           // at the element's temperature
    std::vector<StressLaw> kept;            // r times that: the laws of R
    std::vector<StressLaw> loose;           // (1 - r) times that: the laws of D
    std::vector<Real> weight, weight_back;  // of the rest neighbours before bonds are weighed
    Elements flow;  // D: rest is where the particles are, in the world; plastic: minus the elastic strain; state
    StressScratch stress;
    std::vector<Vec3> force;  // of D, in the world [N]
    std::vector<Mat3> gradients;
    FastestRates rates;  // of what has softened or flows
    double stiffest_per = 0,
           damping_per = 0;  // these rates over the unevenness of a stencil, times modulus or viscosity [1]
};

/// Sets up the phases of a scene's elements; `any` tells whether there is something to do at all.
void make_phases(const scene::Scene& scene, const Smoothing& smoothing, const Particles& particles, Solids& solids);

/// Gives elements to particles of solid material that have none, in the order of their ids: what emitters released.
void adopt_particles(const scene::Scene& scene, const Smoothing& smoothing, const Particles& particles, Solids& solids);

/// The melt fraction of every particle from its temperature, and what follows: an element that has become liquid leaves
/// the solids (its particle is then a liquid particle like any other), one that is no more comes back, free of strain,
/// bound to its present neighbours. A body that is solid throughout again gets a rest shape again: the present one,
/// with new rest neighbours, its elastic strain kept as m <- m + u, u <- 0, eps^p <- - Q (eps - eps^p) Q^T (6.15; Q the
/// rotation in J). `gravity` and `last_dt` [s] turn velocities half a step back into those of now.
void change_phases(const scene::Scene& scene, const Vec3& gravity, double last_dt, Particles& particles,
                   Solids& solids);

/// Rest neighbours and moments of bodies that have frozen in another shape, from that shape: after reading a
/// checkpoint.
void find_refrozen_neighbours(Solids& solids);

/// Laws and stencils of all elements at `time` [s]. Requires the neighbours of now.
void prepare_stencils(const scene::Scene& scene, double time, const Smoothing& smoothing, const Particles& particles,
                      const NeighbourLists& neighbours, Solids& solids);

/// Adds the forces of D to those of R, which are in the bodies' frames. Returns D's largest squared stretch.
Real add_flow_forces(Solids& solids);

/// The drift of a sub-step [s], for D.
void drift_flow(double dt, Solids& solids);

/// After the sub-steps of dt [s]: D absorbs the deformation, its elastic strain turned along and partly forgotten by
/// creep; elements of R that are melting and have left their rest shape flow from now on.
///   e <- Q (e + eps) Q^T, eps = (J^T J - 1)/2, J = Q S;   where |e| > k_yield:  e <- (1 - min(dt k_creep, 1)) e
/// Requires solids.gradients of now.
void absorb_flow(double dt, Solids& solids);

/// Pressure -tr(sigma)/3 of an element that flows [Pa]. Its density is the SPH sum's.
Real flow_pressure(const Solids& solids, std::size_t i);

/// The laws of the stencils R, as Elements::law numbers them.
const std::vector<StressLaw>& stencil_laws(const Solids& solids);

/// The law an element meets a wall with: what of it is not liquid. (Of the rest the liquid's wall pressure takes care.)
StressLaw contact_law(const Solids& solids, std::size_t i);

}  // namespace thixo
