// The strategy of a scene, chosen from its words.
#pragma once

#include <vector>

#include "pipeline/contract/scene.h"
#include "sim/space/smoothing.h"
#include "sim/state/materials.h"
#include "sim/state/strategy.h"

namespace thixo {

Strategy strategy_of(const scene::Solver& solver);

/// Raises the viscosity of liquids with tension to the least one that brings a drop to rest, where an implicit solver
/// finds the pressure:
///     mu >= 0.03 sqrt(gamma rho0 d)      [Pa s]
/// d is the spacing. The stress of a surface is no derivative of an energy once it is summed over particles, and stirs
/// them a little all the time. Without a brake a drop of water kept 1 to 8 % of its surface energy in motion; with it
/// less than a thousandth. A drop of radius R that swings loses exp(-5 nu T/R^2) more in a period T: a tenth at R = 8 d.
void calm_surfaces(const Strategy& strategy, const Smoothing& smoothing, Materials& materials);

/// Gives the viscosity of the materials to the implicit solver (implicit_viscosity), where solver.viscosity says so.
/// Automatic: where the explicit limit of step_limits is shorter than all other limits known beforehand, at the
/// expected speed [m/s]. The explicit `viscosity` then becomes 0.
void choose_viscosity_solver(const scene::Solver& solver, const Smoothing& smoothing, double expected_speed,
                             Materials& materials);

}  // namespace thixo
