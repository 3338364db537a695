// What the forces need of a material, from what the scene gives.
#pragma once

#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene.h"
#include "sim/smoothing.h"

namespace thixo {

struct MaterialParams {
    Real density;      // rho0 [kg/m^3]
    Real viscosity;    // mu of the explicit force [Pa s]
    Real stiffness;    // k_gas [Pa]
    Real gamma;        // exponent of the equation of state [1]
    Real cohesion;     // k_cohesion [Pa m^6/kg^2]: P has the term -k_cohesion rho^2/2
    Real sound_speed;  // c = sqrt(dP/drho) at rho0 [m/s]
    Real attraction;          // k_cohesion of the force of sim/tension; one of the two cohesions is 0 [Pa m^6/kg^2]
    Real implicit_viscosity;  // mu of the implicit solve; one of the two is 0 [Pa s]
};

/// Surface tension that a cohesion k_cohesion gives in the continuum limit [N/m]:
///   gamma = pi rho0^2 k_cohesion / 2 integral_0^h w_spiky(r) r^3 dr = 3/56 k_cohesion rho0^2 h
/// (half the work of parting two half-spaces that attract by the pair energy -k_cohesion rho0^2 w_spiky). And its
/// inverse.
Real surface_tension_of(Real cohesion, Real density, Real support);
Real cohesion_for(Real surface_tension, Real density, Real support);

/// Stiffness that keeps compression near 1 % at a speed U [m/s]: c = 10 U, for the density changes by U^2/c^2 (Monaghan
/// 1994);
///   k_gas = c^2 rho0 / gamma.   [Pa]
Real stiffness_for(Real speed, Real density, Real gamma);

/// Resolves the scene's materials. Where the pressure solver is implicit there is no sound: stiffness and sound speed are
/// zero. `expected_speed` U [m/s] is used where a material names no stiffness. A packing has
/// no pairs nearer than its spacing, where w_spiky is largest, so the continuum's cohesion would give it less tension
/// than the scene asks for: the cohesion taken is that of the continuum over packed_tension (0.79 at h = 2 spacings).
std::vector<MaterialParams> resolve_materials(const std::vector<scene::Material>& materials, Real expected_speed,
                                              const Smoothing& smoothing, scene::Pressure solver = scene::Pressure::eos);

}  // namespace thixo
