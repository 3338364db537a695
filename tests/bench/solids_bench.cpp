// Steps of elastic bodies. The reference of the same run is one bare sweep over the same rest lists. Read a sub-step in
// such sweeps, and items/s (particle-sub-steps a second).
//     elastic_sub_step/threads/particles           a moving cantilever without walls, one explicit sub-step
//     cantilever/log10(E)/step/particles/levels    bends under its weight from straight for 0.2 s
//       step                                       0: leapfrog, for 0.02 s; else length of implicit steps [ms]
//       levels                                     preconditioner, 1: blocks alone; 2: with the coarse grid
//     embedded_surface/threads/surfels             moves the surfels of a body of 200 particles
// Of the cantilever read simulated_s_per_hour. Kugelstadt et al. 2021 in SPlisHSPlasH 2.13 was measured with E = 1e6.
#include <benchmark/benchmark.h>

#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "sim/state/solids.h"
#include "tests/bench/beam.h"

namespace {

using namespace thixo;

/// The beam with surfels, or with implicit steps.
Simulation beam(double particles, int surfels, double modulus = 1e6, bool implicit = false) {
    scene::Scene scene = fixture::held_beam(particles, modulus);
    if (implicit) scene.solver.solids = scene::SolidSteps::implicit_euler;
    scene.bodies[0].surfels = surfels;
    scene.surface.enabled = surfels > 0;
    return make_simulation(scene);
}

void elastic_sub_step(benchmark::State& state) {
    set_thread_count(static_cast<int>(state.range(0)));
    Simulation s = beam(static_cast<double>(state.range(1)), 0);
    fixture::steps(s, 1, 0.002);
    // Strain, stress and forces are all but a few per cent of a sub-step, which ends with a step.
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
        static_cast<double>(s.solids.elements.bonds.neighbour.size()) / static_cast<double>(s.particles.size());
}

template <class T>
std::size_t bytes(const std::vector<T>& v) {
    return v.capacity() * sizeof(T);
}

void cantilever(benchmark::State& state) {
    set_thread_count(1);
    const bool implicit = state.range(1) != 0;
    const double dt = implicit ? 1e-3 * static_cast<double>(state.range(1)) : 2e-3, whole = implicit ? 0.2 : 0.02;
    for (auto _ : state) {
        Simulation s =
            beam(static_cast<double>(state.range(2)), 0, std::pow(10.0, static_cast<double>(state.range(0))), implicit);
        ImplicitScratch& i = s.solid_scratch.implicit;
        i.two_levels = state.range(3) == 2;
        const double begin = wall_seconds();
        fixture::steps(s, 1, 1e-9);  // prepares what later steps reuse
        state.counters["set_up_s"] = wall_seconds() - begin;
        s.stats = StepStats{};
        const int steps = static_cast<int>(std::lround(whole / dt));
        fixture::steps(s, steps, dt);
        state.SetIterationTime(s.stats.solids_seconds);
        state.counters["simulated_s_per_hour"] = 3600 * whole / s.stats.solids_seconds;
        state.counters["sub_steps"] = s.stats.solid_sub_steps;
        if (!implicit) continue;
        state.counters["newton"] = static_cast<double>(s.stats.solid_newton) / steps;
        state.counters["iterations"] = static_cast<double>(s.stats.solid_iterations) / steps;
        state.counters["unconverged"] = s.stats.solid_unconverged;
        const std::size_t memory = bytes(i.stiffness.at) + bytes(i.stiffness.scratch.stencil) +
                                   bytes(i.stiffness.scratch.own) + bytes(i.boundaries.wall) + bytes(i.start) +
                                   bytes(i.base) + bytes(i.rigid) + bytes(i.change) + bytes(i.direction) +
                                   bytes(i.residual) + bytes(i.product) + bytes(i.preconditioned) + bytes(i.diagonal) +
                                   bytes(i.inverse) + bytes(i.elastic) + bytes(i.viscous) + i.coarse.bytes();
        state.counters["bytes_per_particle"] = static_cast<double>(memory) / static_cast<double>(s.particles.size());
        state.counters["nodes"] = static_cast<double>(i.coarse.nodes());
    }
}

void bare_sweep(benchmark::State& state) {
    set_thread_count(1);
    Simulation s = beam(static_cast<double>(state.range(0)), 0);
    const Elements& e = s.solids.elements;
    Real total = 0;
    for (auto _ : state)
        for (std::size_t i = 0; i < e.size(); ++i) {
            Real sum = 0;
            for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k)
                sum += e.bonds.weight[k] * e.displacement[e.bonds.neighbour[k]].x;
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
BENCHMARK(cantilever)
    ->ArgsProduct({{6}, {0, 5}, {3'000, 30'000}, {1, 2}})
    ->ArgsProduct({{10}, {0, 5}, {3'000, 30'000}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime()
    ->Iterations(1);
BENCHMARK(bare_sweep)->Arg(30'000)->Unit(benchmark::kMillisecond);
BENCHMARK(embedded_surface)->Args({1, 10'000})->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
