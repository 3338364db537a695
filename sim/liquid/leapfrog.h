// Time integration: leapfrog in kick-drift form.
#pragma once

#include "sim/state/particles.h"

namespace thixo {

/// Leapfrog with a changing step (dissertation 7.2), steps in s:
///     v(t + dt/2) = v(t - dt0/2) + (dt0 + dt)/2 a(t)
///     x(t + dt)   = x(t) + dt v(t + dt/2)
/// dt0 = `last_dt`; 0 makes the first half step. With dt0 = dt the scheme is time-reversible to rounding for forces
/// that depend on positions alone. Solid particles stay: sim/loop/solid_steps.h moves them.
void leapfrog(Particles& particles, double last_dt, double dt);

}  // namespace thixo
