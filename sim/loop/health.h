// One check a step that the state is finite and possible.
#pragma once

#include "sim/loop/simulation.h"
#include "sim/loop/time_step.h"

namespace thixo {

/// Throws DivergedError where a particle's position, velocity, density or acceleration is not finite, or its speed
/// exceeds ten times the speed of sound. The message names particle, frame, sub-step and term, the likely cause, and
/// the command that runs the frame again.
void check_health(const Simulation& sim, const StepLimits& limits);

/// The same for solids after their sub-steps: places and speeds are finite and possible, and no element's strain is
/// beyond all bounds.
void check_solids_health(const Simulation& sim, const SolidReport& report);

}  // namespace thixo
