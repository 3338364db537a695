// Steps of solids by Euler's method backwards in time, for stiff bodies. Dissertation 7.2; Mueller et al. 2004.
#pragma once

#include <functional>

#include "sim/contact/boundary_terms.h"
#include "sim/solid/coarse_grid.h"
#include "sim/solid/stiffness.h"

namespace thixo {

struct ImplicitReport {
    int newton = 0, iterations = 0;  // of Newton's method, of conjugate gradients in all of them
    bool converged = true;
};

/// Scratch of a step, kept so that a steady simulation allocates little.
struct ImplicitScratch {
    Stiffness stiffness;
    BoundaryTerms boundaries;
    std::vector<Quad> start, base;             // u at the beginning, in the frame of the end and in its own [m]
    std::vector<Quad> rigid;                   // velocity of the rigid motion at the end [m/s]
    std::vector<Vec3> turning;                 // acceleration of what turns along [m/s^2]
    std::vector<Vec3d> angular;                // of each body about its centre, before, in the frame of the end
    std::vector<Quad> change, direction;       // of u [m]
    std::vector<Vec3> residual, product;       // [N]
    std::vector<Vec3> preconditioned;          // [m]
    std::vector<Symmetric> diagonal, inverse;  // of M/dt^2 + K [N/m], [m/N]
    std::vector<Symmetric> bounds;             // of contact and walls [N/m]
    CoarseGrid coarse;
    bool two_levels = true;  // to measure what the coarse grid is good for
    StressScratch stress;
    // Of the bonds' version that they were made for.
    std::uint64_t version = 0;
    std::vector<Symmetric> elastic, viscous;
};

/// Brings what is held to where it is at a time [s], a step [s] after it was where it is.
using MoveHeld = std::function<void(double time, double dt)>;

/// From t to t + dt [s]: u' and v' = (u' - u)/dt with
///   M (v' - v)/dt = f(u', v')                       f of elasticity, contact, walls and what is held over the step
/// by Newton's method with a search along each direction, which solves (M/dt^2 + K) du = f - M (v' - v)/dt by conjugate
/// gradients, preconditioned with the inverse 3x3 blocks plus a coarse grid's, until what is left is no more than
/// `tolerance` of the forces (norms sqrt(sum |.|^2/m)). Stable at any step; damps what vibrates faster than it. The
/// bodies' frames go ahead with their rigid motion first, in which u and v are: so displacements stay small, turning is
/// no strain, and spin is not damped. The momenta of each body that nothing holds change by the forces to rounding,
/// whatever the tolerance. Requires contacts found at t; walls are left at t + dt. Elements' velocities are those of t,
/// not of half a step before.
ImplicitReport step_implicitly(double time, double dt, double tolerance, Walls& walls, const MoveHeld& move_held,
                               Solids& solids, ImplicitScratch& scratch);

}  // namespace thixo
