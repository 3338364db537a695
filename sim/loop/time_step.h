// The length of the next step.
#pragma once

#include <limits>
#include <vector>

#include "pipeline/contract/scene_simulation.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"

namespace thixo {

/// Upper bounds of the step [s], and their causes.
struct StepLimits {
    double signal = 0;     // cfl h / (c + v)
    double motion = 0;     // h / (10 v): a particle moves a fifth of a spacing, and never passes through a wall;
                           // cfl h / (2 v) where there is no sound
    double viscosity = 0;  // viscous_limit
    double force = 0;      // sqrt(h / a) / 4
    double maximum = 0;    // the scene's
    double fastest = 0;    // largest particle or wall speed v [m/s]
    double smallest() const;
    const char* cause() const;
};

/// Of matter whose own sub-steps set the pace.
inline constexpr StepLimits kNoLimits{1e30, 1e30, 1e30, 1e30, 1e30, 0};

/// The longest step of the explicit viscous force [s] at nu = mu/rho [m^2/s]. With an equation of state (4.7) levels a
/// particle's velocity at the rate
///     nu sum_j V_j lap w_visc = 15 nu/h^2      [1/s]
/// The worst mode of the neighbourhood decays at most twice as fast. An explicit step is stable up to 2 over that rate,
///     h^2/(15 nu)
/// and 3/8 of it is used, because v(t) is predicted and not exact. The pair force of viscous_pairs.h has the fastest rate
/// 55 nu/h^2, that of neighbours which meet head on in the packing. With continued velocities it is stable up to 1 over
/// that; h^2/(80 nu) leaves room for disorder.
inline double viscous_limit(double support, double nu, bool compressible) {
    return nu > 0 ? support * support / ((compressible ? 40 : 80) * nu) : std::numeric_limits<double>::infinity();
}

/// Limits for the state at time t (signal and force: Monaghan 1992).
StepLimits step_limits(const Particles& particles, const Sweep& sweep, const Materials& materials,
                       const Smoothing& smoothing, const scene::TimeStep& params, double wall_speed);

/// Divides the remaining time to the next frame evenly, without sliver steps: n = ceil(remaining/limit). Returns
/// remaining/n [s].
double divide_evenly(double remaining, double limit);

}  // namespace thixo
