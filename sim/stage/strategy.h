// The strategy of a scene, chosen from its words.
#pragma once

#include <vector>

#include "pipeline/contract/scene.h"
#include "sim/space/smoothing.h"
#include "sim/state/materials.h"
#include "sim/state/strategy.h"

namespace thixo {

Strategy strategy_of(const scene::Solver& solver);

/// Gives the viscosity of the materials to the implicit solver (implicit_viscosity), where solver.viscosity says so.
/// Automatic: where the explicit limit of step_limits is shorter than all other limits known beforehand, at the
/// expected speed [m/s]. The explicit `viscosity` then becomes 0.
void choose_viscosity_solver(const scene::Solver& solver, const Smoothing& smoothing, double expected_speed,
                             Materials& materials);

}  // namespace thixo
