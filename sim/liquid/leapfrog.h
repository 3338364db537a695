// Time integration: leapfrog in kick-drift form.
#pragma once

#include "sim/state/particles.h"

namespace thixo {

/// v(t + dt/2) = v(t - dt0/2) + (dt0 + dt)/2 a(t)    (dissertation 7.2, with a changing step; dt0 = 0 makes the first
/// half step) x(t + dt)   = x(t) + dt v(t + dt/2) Steps in s. With dt0 = dt time-reversible to rounding for forces that
/// depend on positions alone. Solid particles stay: sim/solid moves them.
void leapfrog(Particles& particles, double last_dt, double dt);

}  // namespace thixo
