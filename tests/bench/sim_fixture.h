// The liquid the simulation benchmarks run on: a block in mid splash, so that neighbour counts and memory order are
// those of a real run.
#pragma once

#include "pipeline/base/parallel.h"
#include "tests/sim/fixture.h"

namespace thixo::fixture {

/// A dam of about this many particles that has fallen for a tenth of a second, in a tank 0.8 m long.
inline Simulation fallen_dam(double particles) {
    const double depth = 0.3;
    const double spacing = std::cbrt(0.2 * 0.15 * depth / particles);
    scene::Scene scene = tank({0.8, 0.15, 0.6}, 0.01, spacing);
    scene.bodies = {body("dam", shape_at({-0.3, 0, depth / 2}, scene::BoxShape{{0.2, 0.15, depth}, 0}))};
    scene.frames.fps = 10;
    Simulation s = make_simulation(scene);
    advance_frame(s);
    return s;
}

}  // namespace thixo::fixture
