// Steps of solids by Euler's method backwards in time, for stiff bodies. Dissertation 7.2; Mueller et al. 2004.
#pragma once

#include <functional>

#include "sim/contact/boundary_terms.h"
#include "sim/solid/coarse_grid.h"
#include "sim/solid/stiffness.h"

namespace thixo {

struct ImplicitReport {
    int newton = 0, iterations = 0;  // of Newton's method; of conjugate gradients, over all Newton iterations
    bool converged = true;
};

/// Scratch of a step. It is kept between steps, so that a steady simulation allocates little.
struct ImplicitScratch {
    Stiffness stiffness;
    BoundaryTerms boundaries;
    std::vector<Quad> start, base;             // u at the beginning: in the end's frame, in its own frame [m]
    std::vector<Quad> rigid;                   // velocity of the rigid motion at the end [m/s]
    std::vector<Vec3> turning;                 // acceleration of places that turn with the body [m/s^2]
    std::vector<Vec3d> angular;                // angular momentum of each body before, in the end's frame [kg m^2/s]
    std::vector<Quad> change, direction;       // of u [m]
    std::vector<Vec3> residual, product;       // [N]
    std::vector<Vec3> preconditioned;          // [m]
    std::vector<Symmetric> diagonal, inverse;  // of M/dt^2 + K [N/m], [m/N]
    std::vector<Symmetric> bounds;             // of contact and walls [N/m]
    CoarseGrid coarse;
    bool two_levels = true;  // off: to measure the gain of the coarse grid
    StressScratch stress;
    // Diagonal blocks, and the bonds' version that they were computed for.
    std::uint64_t version = 0;
    std::vector<Symmetric> elastic, viscous;
};

/// Moves what is held to its place at a time [s], a step [s] after its present place.
using MoveHeld = std::function<void(double time, double dt)>;

/// Advances the solids from t to t + dt [s] by Euler's method backwards in time:
///     u' = u + dt v'
///     M (v' - v)/dt = f(u', v')
/// f holds elasticity, contact, walls and the handles' motion over the step. Newton's method with a search along each
/// direction solves it. Each direction solves
///     (M/dt^2 + K) du = f - M (v' - v)/dt
/// by conjugate gradients, preconditioned with the inverse 3x3 blocks plus a coarse grid. The iteration ends when the
/// residual is at most `tolerance` of the forces, both in the norm
///     sqrt(sum |.|^2/m)
/// The step is stable at any dt. It damps vibrations faster than dt. The bodies' frames first go ahead with their rigid
/// motion; u and v are measured in these frames. Displacements therefore stay small, turning makes no strain, and spin
/// is not damped. The momenta of each free body change by the forces to rounding, at any tolerance. Requires contacts
/// found at t. Walls are left at t + dt. Elements' velocities are those of t, not of half a step before.
ImplicitReport step_implicitly(double time, double dt, double tolerance, Walls& walls, const MoveHeld& move_held,
                               Solids& solids, ImplicitScratch& scratch);

}  // namespace thixo
