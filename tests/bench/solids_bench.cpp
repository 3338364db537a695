// One sub-step of the explicit elastic bodies: strain, stress, forces, walls, leapfrog. The reference of the same run
// is one bare sweep over the same rest lists: read a sub-step in such sweeps, and items/s (particle-sub-steps a
// second).
//   elastic_sub_step/threads/particles     a cantilever in motion, no wall
//   embedded_surface/threads/surfels       bringing the surfels of a body of 200 particles to where they are
#include <benchmark/benchmark.h>

#include <memory>

#include "pipeline/base/parallel.h"
#include "sim/solid/solids.h"
#include "tests/sim/fixture.h"

namespace {

using namespace thixo;

/// A beam 4 x 1 x 1 of about this many particles, held at one end under gravity.
Simulation beam(double particles, int surfels) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.materials[0].elastic.youngs_modulus = 1e6;
    scene.materials[0].elastic.poisson_ratio = 0.33;
    scene.materials[0].viscosity = 0;
    scene.solver.spacing = std::cbrt(4 / particles);
    scene.bodies = {fixture::body("beam", fixture::shape_at({0, 0, 0}, scene::BoxShape{{4, 1, 1}, 0}))};
    scene.bodies[0].surfels = surfels;
    scene.surface.enabled = surfels > 0;
    scene::Handle wall;
    wall.name = "wall";
    wall.body = "beam";
    wall.region = fixture::shape_at({-2, 0, 0}, scene::BoxShape{{0.2, 2, 2}, 0});
    scene.handles = {wall};
    return make_simulation(scene);
}

void elastic_sub_step(benchmark::State& state) {
    set_thread_count(static_cast<int>(state.range(0)));
    Simulation s = beam(static_cast<double>(state.range(1)), 0);
    fixture::steps(s, 1, 0.002);
    // Strain, stress and forces: all but the last few parts in a hundred of a sub-step, which ends with a step.
    s.stats = StepStats{};
    double seconds = 0;
    std::int64_t sub_steps = 0;
    for (auto _ : state) {
        s.stats = StepStats{};
        fixture::steps(s, 1, 0.02);
        state.SetIterationTime(s.stats.solids_seconds / s.stats.solid_sub_steps);
        seconds += s.stats.solids_seconds;
        sub_steps += s.stats.solid_sub_steps;
    }
    state.counters["particles"] = static_cast<double>(s.particles.size());
    state.counters["ns_per_particle"] =
        1e9 * seconds / static_cast<double>(sub_steps) / static_cast<double>(s.particles.size());
    state.counters["neighbours"] =
        static_cast<double>(s.solids.elements.neighbour.size()) / static_cast<double>(s.particles.size());
}

void bare_sweep(benchmark::State& state) {
    set_thread_count(1);
    Simulation s = beam(static_cast<double>(state.range(0)), 0);
    const Elements& e = s.solids.elements;
    Real total = 0;
    for (auto _ : state)
        for (std::size_t i = 0; i < e.size(); ++i) {
            Real sum = 0;
            for (std::size_t k = e.begin[i]; k < e.begin[i + 1]; ++k)
                sum += e.weight[k] * e.displacement[e.neighbour[k]].x;
            total += sum;
        }
    benchmark::DoNotOptimize(total);
}

void embedded_surface(benchmark::State& state) {
    set_thread_count(static_cast<int>(state.range(0)));
    Simulation s = beam(200, static_cast<int>(state.range(1)));
    for (auto _ : state) refresh_surface(s);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(s.surface.size()));
}

BENCHMARK(elastic_sub_step)
    ->Args({1, 3'000})
    ->Args({1, 30'000})
    ->Args({2, 30'000})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();
BENCHMARK(bare_sweep)->Arg(30'000)->Unit(benchmark::kMillisecond);
BENCHMARK(embedded_surface)->Args({1, 10'000})->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
