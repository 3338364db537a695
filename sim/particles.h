// All particles of a simulation as a structure of arrays; element k of every array is particle k. In-memory order is a
// function of (cell key, id) only.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/base/math.h"

namespace thixo {

enum class Kind : std::uint8_t { liquid, solid };

struct Particles {
    /// Groups of attributes that not every scene has; arrays of the others stay empty.
    struct Groups {
        bool surface = true;             // surface_position
        bool implicit_pressure = true;   // restoring
        bool implicit_viscosity = true;  // viscous_acceleration
        bool spacing = true;             // spacing
    } has;
    std::vector<std::int64_t> id;            // unique for ever, given in order of creation
    std::vector<Vec3> position;              // x [m]
    std::vector<Vec3> velocity;              // v [m/s] at t - dt/2 between steps (leapfrog)
    std::vector<Vec3> acceleration;          // f/m [m/s^2] of the last step
    std::vector<Vec3> viscous_acceleration;  // the implicit viscosity's share of it [m/s^2]
    std::vector<Real> mass;                  // m [kg]
    std::vector<Real> rest_volume;           // V0 = m/rho0 [m^3]
    std::vector<Real> spacing;               // of the lattice about it, where that is not the same everywhere [m]
    std::vector<Real> density;               // rho [kg/m^3], summation density with the walls' share
    std::vector<Real> pressure;              // P [Pa]
    std::vector<Real> restoring;         // the density solve's pressure times time squared, of the last step [Pa s^2]
    std::vector<double> temperature;     // T [degC]; in single precision a slow change of one step would be lost
    std::vector<Real> melt;              // b: 0 a solid, 1 a liquid, in between what melts [1]
    std::vector<Vec3> surface_position;  // x at the last surface update [m]; written by sim/surface
    std::vector<std::int32_t> material;  // index into Scene::materials
    std::vector<std::int32_t> body;      // id of the body (emitters and scene bodies give the first ones)
    std::vector<Kind> kind;

    std::size_t size() const { return id.size(); }
};

/// f(name, array) for every array of the groups there are, so that resize, reorder and checkpoint cannot forget one. P
/// is Particles or const Particles.
template <class P, class F>
void for_each_array(P& p, F&& f) {
    f("id", p.id);
    f("position", p.position);
    f("velocity", p.velocity);
    f("acceleration", p.acceleration);
    if (p.has.implicit_viscosity) f("viscous_acceleration", p.viscous_acceleration);
    f("mass", p.mass);
    f("rest_volume", p.rest_volume);
    if (p.has.spacing) f("spacing", p.spacing);
    f("density", p.density);
    f("pressure", p.pressure);
    if (p.has.implicit_pressure) f("restoring", p.restoring);
    f("temperature", p.temperature);
    f("melt", p.melt);
    if (p.has.surface) f("surface_position", p.surface_position);
    f("material", p.material);
    f("body", p.body);
    f("kind", p.kind);
}

/// Sets the length of every array; new elements are zero.
void resize(Particles& p, std::size_t count);

/// Room for one array, kept so that reordering allocates nothing.
using ReorderScratch = std::vector<Vec3>;

/// New element k is old element order[k]; order is a permutation.
void reorder(Particles& p, const std::vector<Index>& order, ReorderScratch& scratch);

/// Appends a particle of this id, all else zero, and returns its index.
Index add_particle(Particles& p, std::int64_t id);

}  // namespace thixo
