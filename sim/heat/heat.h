// Heat: conduction between particles and from isothermal walls, latent heat, sources.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "pipeline/geometry/shape.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/space/walls.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"
#include "sim/state/screened_pair.h"

namespace thixo {

/// Heat per mass above 0 degC [J/kg]: c T, plus latent heat in proportion from solidus to liquidus. This is the
/// enthalpy method (Voller & Cross 1981). Enthalpy rises with temperature, so that each determines the other.
double enthalpy(double temperature, const scene::Thermal& material);
/// The temperature of an enthalpy [degC].
double temperature_of(double enthalpy, const scene::Thermal& material);

/// The conduction from a wall at distance d in [0, h), per k V (T_wall - T) [1/m^2]. It is the kernel's integral over a
/// half-space. The temperature there continues on the line from the particle to the wall's surface, so that a linear
/// profile is stationary. `least` [m] bounds d from below.
Real wall_conduction(Real distance, Real support, Real least);

struct HeatSourceRegion {
    Shape region;
    double power, from, to;  // W/m^3, s
};

/// What makes heat flow, beside the materials.
struct HeatDrive {
    std::vector<HeatSourceRegion> sources;
    double fastest = 0;              // the largest diffusivity k/(rho c) [m^2/s]
    std::string fastest_material{};  // its material
    bool any() const { return !sources.empty() || fastest > 0; }
};
HeatDrive make_heat(const scene::Scene& scene, const Materials& materials);

/// What heat flows by.
struct HeatPaths {
    const Materials& materials;
    const HeatDrive& drive;
    std::span<const ScreenedPair> screened{};
};

/// Scratch of one step.
struct HeatScratch {
    std::vector<Quad> place;   // x [m], T [degC]
    std::vector<Quad> matter;  // conductivity [W/(m K)], volume [near h^3]
    std::vector<double> gain;  // of an explicit step [J/s]
};

/// Conducts heat for dt [s] from time t [s], in as many explicit steps as stability needs with the present neighbours:
///     m_i dh_i/dt = V_i sum_j V_j k_ij (T_j - T_i) lap w_visc(r_ij) + walls + sources      [W]
///     k_ij = 2 k_i k_j/(k_i + k_j);  0 if both are 0
/// (dissertation 6.17-6.19; harmonic mean: Cleary & Monaghan 1999). The heat between two particles is equal for both,
/// so that the total heat stays. In and out: particles.temperature [degC]. Returns the number of steps. Requires the
/// places and volumes of this step's sweep.
int conduct_heat(Particles& particles, const SweepInput& input, const HeatPaths& paths, double t, double dt,
                 HeatScratch& scratch);

}  // namespace thixo
