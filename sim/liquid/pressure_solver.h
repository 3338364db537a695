// The implicit pressure solver: pressures that are never negative and leave no particle denser than its rest density.
#pragma once

#include "sim/liquid/pressure_system.h"

namespace thixo {

struct SolveLimits {
    double tolerance = 0;  // of the mean residual [1]
    int iterations = 0;    // at most
};

/// The step of a divergence solve [s], and the limits of the solve.
struct DivergenceSolve {
    double kick = 0, dt = 0;
    SolveLimits limits;
};

/// How a solve went. One iteration is one application of the operator: two sweeps over the neighbours.
struct SolveReport {
    int iterations = 0;
    double residual = 0;     // mean over particles of |s* - 1| under pressure, max(s* - 1, 0) elsewhere [1]
    bool converged = false;  // within the tolerance
};

/// Scratch of a solve. It is kept, so that a solve allocates nothing.
struct SolveScratch {
    std::vector<Real> residual;   // s* - 1 with the present pressure [1]
    std::vector<Real> direction;  // of the pressure [Pa]
    std::vector<Real> response;   // - change of s* by the direction [1]
    std::vector<Vec3> shift;      // the density solve's displacement [m]
    std::vector<Vec3> push;       // acceleration by the present pressure [m/s^2]
};

/// Divergence solve: the pressures p >= 0 [Pa] for the next leapfrog step
///     v <- v + kick (a + F(p)/m)
///     x <- x + dt v
/// With them the step compresses no full particle, and fills no other beyond its rest density:
///     dt s'_i(v + kick a) - dt kick (A p)_i <= max(0, 0.998 - s_i)      complementary to p
/// dt, kick in s. In: particles.acceleration a of all other forces; particles.pressure of the last step, the first
/// guess. Out: particles.pressure, and particles.acceleration with the pressure's share. Requires measure_density.
SolveReport remove_divergence(Particles& particles, const NeighbourLists& neighbours,
                              const std::vector<WallEffect>& walls, const Smoothing& smoothing,
                              const DivergenceSolve& params, PressureSystem& system, SolveScratch& scratch);

/// Density solve: scratch.shift, the displacements of least sum m dx^2 that correct the step of the divergence solve
/// just made. They leave no particle denser than its rest density, to first order:
///     s* = s + dt s'(v) + J dx <= 1
/// They are not part of the velocities. DFSPH (Bender & Koschier 2015) adds them to the velocities. The compression
/// that the linearised step leaves then returns as speed and makes the next step's error: a tank never comes to rest.
/// The first guess is particles.restoring of the last step, unless zero is already within the tolerance. A fluid at
/// rest stays untouched.
SolveReport restore_density(Particles& particles, const NeighbourLists& neighbours,
                            const std::vector<WallEffect>& walls, const Smoothing& smoothing, const SolveLimits& limits,
                            PressureSystem& system, SolveScratch& scratch);

}  // namespace thixo
