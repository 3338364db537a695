// A dam break with which other solvers are timed. A block of 0.96 x 0.96 x 0.76 m falls in a tank of 3 x 2.5 x 0.84 m.
// It has about 94,000 particles with 37 neighbours each. `dfsph` runs at a density error of 0.05 %, for two seconds, on
// two threads, without surface and files. Prints simulated seconds per hour of wall time and milliseconds of each part
// of a step. The time of a bare density sweep is the unit in which to read a step. Arguments: particles (94000),
// simulated seconds (2), threads (2), divergence tolerance (0.001, as the other solvers).
#include <fmt/core.h>

#include <chrono>
#include <cstdlib>

#include "sim/liquid/density.h"
#include "tests/bench/sim_fixture.h"

namespace {

using namespace thixo;

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Simulation dam(double particles, double divergence_tolerance) {
    const Vec3d size{0.96, 0.96, 0.76};
    scene::Scene scene = fixture::tank({3, 2.5, 0.84}, 0.01, std::cbrt(size.prod() / particles));
    scene.solver.support = 2.17;
    scene.solver.pressure = scene::Pressure::dfsph;
    scene.solver.density_tolerance = 5e-4;
    scene.solver.divergence_tolerance = divergence_tolerance;
    scene.bodies = {fixture::body("dam", fixture::shape_at({-1.02, -0.77, 0.38}, scene::BoxShape{size, 0}))};
    scene.frames.fps = 10;
    return make_simulation(scene);
}

/// Time of one density sweep over the current lists, without walls, the fastest of five [s].
double bare_sweep(Simulation& s) {
    const Walls none;
    double best = 1e30;
    for (int k = 0; k < 5; ++k) {
        const auto start = std::chrono::steady_clock::now();
        compute_density(s.particles, s.neighbours, none, s.problem.smoothing, s.sweep);
        best = std::min(best, seconds_since(start));
    }
    return best;
}

}  // namespace

int main(int argc, char** argv) {
    const auto argument = [&](int k, double usual) { return argc > k ? std::atof(argv[k]) : usual; };
    set_thread_count(static_cast<int>(argument(3, 2)));
    Simulation s = dam(argument(1, 94'000), argument(4, 1e-3));
    const double length = argument(2, 2);
    const auto start = std::chrono::steady_clock::now();
    while (s.clock.time < length - 1e-9) advance_frame(s);
    const double wall = seconds_since(start), steps = s.stats.steps;
    const auto ms = [&](double seconds) { return 1e3 * seconds / steps; };
    fmt::print("{} particles, {:.1f} neighbours, {:.1f} s simulated in {:.1f} s: {:.1f} simulated seconds per hour\n",
               s.particles.size(), static_cast<double>(s.stats.pairs) / static_cast<double>(s.stats.particle_steps),
               s.clock.time, wall, 3600 * s.clock.time / wall);
    fmt::print("{} steps, {:.2f} ms each of {:.2f} ms simulated; iterations: density {:.1f}, divergence {:.1f}\n",
               steps, 1e3 * wall / steps, 1e3 * s.clock.time / steps, s.stats.density.iterations / steps,
               s.stats.divergence.iterations / steps);
    fmt::print(
        "ms: neighbours {:.1f}, density {:.1f}, forces {:.1f}, pressure {:.1f}, integration {:.1f}; a bare sweep "
        "{:.1f}\n",
        ms(s.stats.neighbours_seconds), ms(s.stats.density_seconds), ms(s.stats.forces_seconds),
        ms(s.stats.pressure_seconds), ms(s.stats.integration_seconds), 1e3 * bare_sweep(s));
}
