// A whole step of the two pressure solvers. The reference of the same run is one bare sweep over the same neighbour
// lists. Read a step's time in such sweeps, which depends little on other load, and items/s (particle-steps a second).
//     step_of/solver/support           a dam of 100,000 in mid splash; support in hundredths of the spacing
//     steps_by_size/solver/particles   time per particle from 10 thousand to a million
// The solver is 0 for eos and 1 for dfsph.
#include <benchmark/benchmark.h>

#include <cstdlib>

#include "tests/bench/sim_fixture.h"

namespace {

using namespace thixo;

// The number of threads of the process: the environment's THREADS, or one.
int threads() {
    const char* asked = std::getenv("THREADS");
    return asked ? std::atoi(asked) : 1;
}

void report(benchmark::State& state, const Simulation& s) {
    state.SetItemsProcessed(s.stats.particle_steps);
    const auto share = [&](double seconds) { return 1e9 * seconds / static_cast<double>(s.stats.particle_steps); };
    state.counters["neighbours_ns"] = share(s.stats.neighbours_seconds);
    state.counters["density_ns"] = share(s.stats.density_seconds);
    state.counters["forces_ns"] = share(s.stats.forces_seconds);
    state.counters["pressure_ns"] = share(s.stats.pressure_seconds);
    state.counters["integration_ns"] = share(s.stats.integration_seconds);
    const auto each = [&](int count) { return static_cast<double>(count) / static_cast<double>(s.stats.steps); };
    state.counters["density_iterations"] = each(s.stats.density.iterations);
    state.counters["divergence_iterations"] = each(s.stats.divergence.iterations);
    state.counters["neighbours"] = static_cast<double>(s.stats.pairs) / static_cast<double>(s.stats.particle_steps);
}

scene::Pressure solver(std::int64_t number) { return number == 0 ? scene::Pressure::eos : scene::Pressure::dfsph; }

void step_of(benchmark::State& state) {
    set_thread_count(threads());
    Simulation& s =
        fixture::shared_fallen_dam(100'000, 0.01 * static_cast<double>(state.range(1)), solver(state.range(0)));
    fixture::free_steps(s, 2);
    s.stats = StepStats{};
    for (auto _ : state) fixture::free_steps(s, 1);
    report(state, s);
}

void steps_by_size(benchmark::State& state) {
    set_thread_count(threads());
    Simulation s = fixture::standing_dam(static_cast<double>(state.range(1)), 2, solver(state.range(0)));
    fixture::free_steps(s, 3);
    s.stats = StepStats{};
    for (auto _ : state) fixture::free_steps(s, 1);
    report(state, s);
}

void bare_sweep(benchmark::State& state) {
    set_thread_count(threads());
    Simulation& s = fixture::shared_fallen_dam(100'000, 0.01 * static_cast<double>(state.range(0)));
    evaluate(s);
    const Poly6 kernel = s.problem.smoothing.density;
    const auto& x = s.particles.position;
    double total = 0;
    for (auto _ : state)
        for (std::size_t i = 0; i < x.size(); ++i) {
            Real sum = 0;
            for (const Index j : s.neighbours[i]) sum += kernel.value((x[i] - x[j]).squaredNorm());
            total += static_cast<double>(sum);
        }
    benchmark::DoNotOptimize(total);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(s.particles.size()));
}

constexpr int kEos = 0, kDfsph = 1;

BENCHMARK(step_of)->Args({kEos, 200})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(bare_sweep)->Arg(200)->Unit(benchmark::kMillisecond);
BENCHMARK(step_of)->Args({kEos, 217})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(bare_sweep)->Arg(217)->Unit(benchmark::kMillisecond);
BENCHMARK(step_of)->Args({kDfsph, 217})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(steps_by_size)
    ->ArgsProduct({{kEos, kDfsph}, {10'000, 30'000, 100'000, 300'000, 1'000'000}})
    ->Unit(benchmark::kMillisecond);

}  // namespace
