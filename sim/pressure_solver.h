// The implicit pressure solver: pressures that are never negative and leave no particle denser than at rest.
#pragma once

#include "sim/pressure_system.h"

namespace thixo {

struct SolveLimits {
    double tolerance = 0;  // of the mean residual [1]
    int iterations = 0;    // at most
};

/// How a solve went. One iteration is one application of the operator: two sweeps over the neighbours.
struct SolveReport {
    int iterations = 0;
    double residual = 0;     // mean over particles of |s* - 1| under pressure, max(s* - 1, 0) elsewhere [1]
    bool converged = false;  // within the tolerance
};

/// Scratch of a solve, kept so that it allocates nothing.
struct SolveScratch {
    std::vector<Real> residual;   // s* - 1 with the present pressure [1]
    std::vector<Real> direction;  // of the pressure [Pa]
    std::vector<Real> response;   // - change of s* by the direction [1]
    std::vector<Real> impulse;    // of the divergence solve over its step [Pa]
    std::vector<Vec3> push;       // acceleration by the present pressure [m/s^2]
};

/// Divergence solve (Bender & Koschier 2015): impulses V0 q that take from the velocities v(t - dt/2) what would compress
/// particles that are full already,
///   s' <= max(0, 1 - s)/dt        complementary to q >= 0
/// dt [s] is the step that led here; no step, no change. The tolerance is that of dt s'. Requires measure_density. Changes
/// particles.velocity and system.motion.
SolveReport remove_divergence(Particles& particles, const NeighbourLists& neighbours,
                              const std::vector<WallEffect>& walls, const Smoothing& smoothing, double dt,
                              const SolveLimits& limits, PressureSystem& system, SolveScratch& scratch);

/// Density solve: the pressures p >= 0 [Pa] with which the next leapfrog step, v <- v + kick (a + F(p)/m), x <- x + dt v, leads
/// to s* <= 1 to first order, complementary to p:
///   s*_i = s_i + dt s'_i(v + kick a) - dt kick (A p)_i
/// In: particles.acceleration a of all other forces; particles.pressure of the last step, the guess it starts from. Out:
/// particles.pressure, and particles.acceleration with the pressure's share.
SolveReport hold_density(Particles& particles, const NeighbourLists& neighbours, const std::vector<WallEffect>& walls,
                         const Smoothing& smoothing, double kick, double dt, const SolveLimits& limits,
                         PressureSystem& system, SolveScratch& scratch);

}  // namespace thixo
