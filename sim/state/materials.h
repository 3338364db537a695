// What the simulation knows of a material: one record, resolved from the scene at set-up.
#pragma once

#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/contract/scene.h"
#include "sim/state/strategy.h"

namespace thixo {

/// The elastic values of a material from an instant on.
struct ElasticValues {
    double time = 0, duration = 0;  // when they hold, and the time before that in which they go over, linearly [s]
    scene::Elastic elastic;         // without the changes, which are entries of their own
    double viscosity = 0;           // damps changes of shape [Pa s]
};

struct ResolvedMaterial {
    // Of the liquid, or of what the solid melts to.
    Real density = 0;             // rho0 [kg/m^3]
    Real viscosity = 0;           // mu of the explicit force [Pa s]
    Real stiffness = 0;           // k_gas [Pa]
    Real gamma = 1;               // exponent of the equation of state [1]
    Real sound_speed = 0;         // c = sqrt(dP/drho) at rho0 [m/s]
    Real tension = 0;             // gamma of the liquid's surface [N/m]
    Real implicit_viscosity = 0;  // mu of the implicit solve; one of the two is 0 [Pa s]
    // Of the solid.
    std::vector<ElasticValues> elastic;  // ascending in time; the first hold from the start
    scene::Fracture fracture;
    // Of both.
    scene::Melting melting;
    scene::Thermal thermal;

    bool solid() const { return elastic.front().elastic.solid(); }
    /// Whether the matter keeps any shape at melt fraction b [1].
    bool keeps_shape(double b) const {
        return solid() && (b < 1 || !melting.any() || melting.liquid.youngs_modulus > 0);
    }
    /// Melt fraction b [1] at a temperature [degC]. What does not melt is solid throughout, or liquid throughout.
    double melt_fraction(double temperature) const {
        return melting.any() ? melting.fraction(temperature) : solid() ? 0 : 1;
    }
};
using Materials = std::vector<ResolvedMaterial>;

/// Stiffness that keeps compression near 1 % at a speed U [m/s], with c = 10 U (Monaghan 1994). Density changes by
/// U^2/c^2.
///     k_gas = c^2 rho0 / gamma      [Pa]
Real stiffness_for(Real speed, Real density, Real gamma);

/// Resolves the scene's materials. An implicit pressure solver knows no sound: stiffness and sound speed are then zero.
/// `expected_speed` U [m/s] is used where a material names no stiffness. Viscosity is that of the explicit force
/// (choose_viscosity_solver, sim/stage/strategy.h).
Materials resolve_materials(const scene::Scene& scene, Real expected_speed, const Strategy& strategy = {});

}  // namespace thixo
