// From the scene's words to how it is solved.
#pragma once

#include <vector>

#include "pipeline/contract/scene.h"
#include "sim/space/smoothing.h"
#include "sim/state/materials.h"
#include "sim/state/strategy.h"

namespace thixo {

Strategy strategy_of(const scene::Solver& solver);

/// Hands the viscosity of the materials to this solver (implicit_viscosity; viscosity, that of forces.h, becomes 0)
/// where solver.viscosity says so, or where, automatic, the explicit limit of step_limits would be shorter than all
/// that is known beforehand of the others at the expected speed [m/s].
void choose_viscosity_solver(const scene::Solver& solver, const Smoothing& smoothing, double expected_speed,
                             std::vector<MaterialParams>& materials);

}  // namespace thixo
