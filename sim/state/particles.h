// All particles of a simulation; row k of every array is particle k. The order in memory is a function of (cell key,
// id) alone.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/base/math.h"
#include "sim/state/phase.h"
#include "sim/state/table.h"

namespace thixo {

struct Particles {
    /// Groups of attributes that not every scene has. Arrays of absent groups stay empty.
    struct Groups {
        bool surface = true;             // surface_position
        bool implicit_pressure = true;   // restoring
        bool implicit_viscosity = true;  // viscous_acceleration
        bool spacing = true;             // spacing
    } has;
    // Written when the particle is made.
    std::vector<std::int64_t> id;        // unique for ever, given in order of creation
    std::vector<Real> mass;              // m [kg]
    std::vector<Real> rest_volume;       // V0 = m/rho0 [m^3]
    std::vector<Real> spacing;           // of the lattice about it, where it is not the same everywhere [m]
    std::vector<std::int32_t> material;  // index into Scene::materials
    std::vector<std::int32_t> body;      // id of the body; sim/fracture writes it where a body splits

    // Written during steps, by the folders named.
    std::vector<Vec3> position;              // x [m]; loop
    std::vector<Vec3> velocity;              // v [m/s] at t - dt/2 between steps (leapfrog); loop
    std::vector<Vec3> acceleration;          // f/m [m/s^2] of the last step; liquid
    std::vector<Vec3> viscous_acceleration;  // the part of it by implicit viscosity [m/s^2]; liquid
    std::vector<Real> density;               // rho [kg/m^3], summation density with the walls' share; liquid, loop
    std::vector<Real> pressure;              // P [Pa]; liquid, loop
    std::vector<Real> restoring;             // the density solve's pressure times time squared [Pa s^2]; liquid
    std::vector<double> temperature;         // T [degC]; single precision would lose a slow change of one step; heat
    std::vector<Phase> phase;                // phase
    std::vector<Real> melt;                  // b: 0 a solid, 1 a liquid, in between melting [1]; phase
    std::vector<Vec3> surface_position;      // x at the last surface update [m]; surface

    std::size_t size() const { return id.size(); }
};

template <class P, class F>
void for_each_field(P& p, F&& f) requires requires {
    p.viscous_acceleration;
}
{
    f("id", Life::state, p.id);
    f("position", Life::state, p.position);
    f("velocity", Life::state, p.velocity);
    f("acceleration", Life::state, p.acceleration);
    if (p.has.implicit_viscosity) f("viscous_acceleration", Life::state, p.viscous_acceleration);
    f("mass", Life::state, p.mass);
    f("rest_volume", Life::state, p.rest_volume);
    if (p.has.spacing) f("spacing", Life::state, p.spacing);
    f("density", Life::state, p.density);
    f("pressure", Life::state, p.pressure);
    if (p.has.implicit_pressure) f("restoring", Life::state, p.restoring);
    f("temperature", Life::state, p.temperature);
    f("phase", Life::state, p.phase);
    f("melt", Life::state, p.melt);
    if (p.has.surface) f("surface_position", Life::state, p.surface_position);
    f("material", Life::state, p.material);
    f("body", Life::state, p.body);
}

}  // namespace thixo
