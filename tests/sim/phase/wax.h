// Materials and scenes of tests in which matter melts.
#pragma once

#include <functional>
#include <string>

#include "tests/sim/fixture.h"

namespace thixo::fixture::melting {

inline scene::Shape box(const Vec3d& where, const Vec3d& size) {
    return fixture::shape_at(where, scene::BoxShape{size, 0});
}

inline scene::Material rubber() {
    scene::Material m;
    m.name = "rubber";
    m.viscosity = 0;
    m.elastic.youngs_modulus = 1e5;
    return m;
}

/// Rubber below 40 degC, a thin liquid above 60.
inline scene::Material wax() {
    scene::Material m = rubber();
    m.name = "wax";
    m.viscosity = 20;
    m.melting.from = 40;
    m.melting.to = 60;
    m.melting.liquid.viscosity = 1;
    m.thermal.heat_capacity = 1000;
    return m;
}

inline scene::Body of(scene::Body b, const std::string& material, double temperature = 20) {
    b.material = material;
    b.temperature = temperature;
    return b;
}

/// Molten wax from above, beside the bodies.
inline scene::Emitter hot_spout() {
    scene::Emitter spout;
    spout.name = "spout";
    spout.material = "wax";
    spout.position = {-0.06, 0, 0.06};
    spout.radius = 0.015;
    spout.temperature = 70;
    return spout;
}

/// Everything at once: a block of wax that stands on a hot floor, a solid one beside it, and water poured on both.
inline scene::Scene busy() {
    scene::Scene s = fixture::empty_space();
    s.world.gravity = {0, 0, -9.81};
    s.materials = {fixture::water(), rubber(), wax()};
    for (scene::Material& m : s.materials) m.thermal.conductivity = 1000;
    s.materials[1].density = 500;
    s.world.boundaries = {fixture::floor_at(0)};
    s.world.boundaries[0].isothermal = true;
    s.world.boundaries[0].temperature = 300;
    s.bodies = {of(fixture::body("candle", box({0, 0, 0.026}, {0.05, 0.05, 0.05})), "wax"),
                of(fixture::body("toy", box({0.07, 0, 0.03}, {0.04, 0.04, 0.04})), "rubber"),
                fixture::body("rain", box({0.03, 0, 0.1}, {0.06, 0.03, 0.03}))};
    s.emitters = {hot_spout()};
    s.frames.fps = 50;
    s.surface.enabled = true;
    for (scene::Body& b : s.bodies) b.surfels = 400;
    return s;
}

/// Gives every particle the temperature at its place.
inline void set_temperature(Simulation& s, const std::function<double(const Vec3&)>& at) {
    for (std::size_t i = 0; i < s.particles.size(); ++i) s.particles.temperature[i] = at(s.particles.position[i]);
}

}  // namespace thixo::fixture::melting
