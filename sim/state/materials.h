// The constants of a material that the forces need, resolved from the scene.
#pragma once

#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene.h"
#include "sim/state/strategy.h"

namespace thixo {

struct MaterialParams {
    Real density;             // rho0 [kg/m^3]
    Real viscosity;           // mu of the explicit force [Pa s]
    Real stiffness;           // k_gas [Pa]
    Real gamma;               // exponent of the equation of state [1]
    Real sound_speed;         // c = sqrt(dP/drho) at rho0 [m/s]
    Real tension;             // gamma of the liquid's surface [N/m]
    Real implicit_viscosity;  // mu of the implicit solve; one of the two is 0 [Pa s]
};

/// Stiffness that keeps compression near 1 % at a speed U [m/s], with c = 10 U (Monaghan 1994). Density changes by
/// U^2/c^2.
///     k_gas = c^2 rho0 / gamma      [Pa]
Real stiffness_for(Real speed, Real density, Real gamma);

/// Resolves the scene's materials. An implicit pressure solver knows no sound: stiffness and sound speed are then zero.
/// `expected_speed` U [m/s] is used where a material names no stiffness. make_simulation sets tension, and how
/// viscosity is solved.
std::vector<MaterialParams> resolve_materials(const std::vector<scene::Material>& materials, Real expected_speed,
                                              const Strategy& strategy = {});

}  // namespace thixo
