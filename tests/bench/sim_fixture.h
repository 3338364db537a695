// The liquid of the simulation benchmarks: a block in mid splash, so that neighbour counts and memory order are those
// of a real run.
#pragma once

#include <memory>
#include <tuple>

#include "pipeline/base/parallel.h"
#include "tests/sim/fixture.h"

namespace thixo::fixture {

/// A dam of about this many particles in a tank 0.8 m long, at its first instant. A support of 2 spacings sees 29
/// neighbours within the liquid, one of 2.17 spacings 37.
inline Simulation standing_dam(double particles, double support = 2, scene::Pressure pressure = scene::Pressure::eos) {
    const double depth = 0.3;
    const double spacing = std::cbrt(0.2 * 0.15 * depth / particles);
    scene::Scene scene = tank({0.8, 0.15, 0.6}, 0.01, spacing);
    scene.solver.support = support;
    scene.solver.pressure = pressure;
    scene.bodies = {body("dam", shape_at({-0.3, 0, depth / 2}, scene::BoxShape{{0.2, 0.15, depth}, 0}))};
    scene.frames.fps = 10;
    return make_simulation(scene);
}

inline void free_steps(Simulation& s, int count) {
    for (int k = 0; k < count; ++k) {
        s.clock.next_frame = s.clock.time + 0.1;
        step(s);
    }
}

/// The dam after it has fallen for a tenth of a second.
inline Simulation fallen_dam(double particles, double support = 2, scene::Pressure pressure = scene::Pressure::eos) {
    Simulation s = standing_dam(particles, support, pressure);
    advance_frame(s);
    return s;
}

/// Shares one dam among consecutive benchmarks with equal arguments. The threads that were set before prepare it.
inline Simulation& shared_fallen_dam(double particles, double support,
                                     scene::Pressure pressure = scene::Pressure::eos) {
    static std::unique_ptr<Simulation> kept;
    static std::tuple<double, double, scene::Pressure> what;
    if (!kept || what != std::tuple(particles, support, pressure)) {
        kept.reset();
        kept = std::make_unique<Simulation>(fallen_dam(particles, support, pressure));
        what = {particles, support, pressure};
    }
    return *kept;
}

}  // namespace thixo::fixture
