// The implicit viscosity of a block of about 96 000 particles. It has settled for 0.2 s on a floor and at a no-slip
// wall. The tolerance is 0.01, and steps have 2 ms. Read the time per iteration in density sweeps of the same run.
#include <benchmark/benchmark.h>

#include "tests/bench/sim_fixture.h"

namespace {

using namespace thixo;

Simulation tank(double viscosity) {
    scene::Scene scene = fixture::tank({3, 2.5, 0.84}, 0.01, 0.0195);
    scene.bodies = {fixture::body("dam", fixture::shape_at({-1, -0.7, 0.4}, scene::BoxShape{{0.96, 0.96, 0.76}, 0}))};
    scene.materials[0].viscosity = viscosity;
    scene.world.boundaries[0].no_slip = true;
    scene.solver.viscosity = scene::Viscosity::implicit_solve;
    scene.solver.viscosity_tolerance = 0.01;
    scene.solver.expected_speed = 0.5;  // a step of 2 ms
    return make_simulation(scene);
}

void viscous_step(benchmark::State& state) {
    Simulation s = tank(static_cast<double>(state.range(0)));
    fixture::steps(s, 100, 2e-3);
    s.stats = StepStats{};
    for (auto _ : state) fixture::steps(s, 1, 2e-3);
    const double steps = s.stats.steps;
    state.counters["particles"] = static_cast<double>(s.particles.size());
    state.counters["viscosity_ms"] = 1e3 * s.stats.viscosity_seconds / steps;
    state.counters["iterations"] = s.stats.viscosity_iterations / steps;
    state.counters["ms_per_iteration"] = 1e3 * s.stats.viscosity_seconds / s.stats.viscosity_iterations;
    state.counters["density_sweep_ms"] = 1e3 * s.stats.density_seconds / steps;
}

BENCHMARK(viscous_step)->Arg(10)->Arg(1000)->Iterations(12)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
