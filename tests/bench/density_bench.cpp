// The density sweep beside a bare reference in the same run: the same sum over the same lists, without walls. Read
// particles/s, and the ratio of the two times. The time of walls is the difference to the sweep without walls.
#include <benchmark/benchmark.h>

#include "sim/liquid/density.h"
#include "tests/bench/sim_fixture.h"

namespace {

using namespace thixo;

// Support in hundredths of the spacing.
Simulation& dam(const benchmark::State& state) {
    set_thread_count(2);
    Simulation& s = fixture::shared_fallen_dam(100'000, 0.01 * static_cast<double>(state.range(0)));
    set_thread_count(1);
    evaluate(s);
    pack_motion(s.particles, 0, false, s.sweep);
    return s;
}

void report(benchmark::State& state, const Simulation& s) {
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(s.particles.size()));
    state.counters["neighbours"] = static_cast<double>(s.neighbours.total()) / static_cast<double>(s.particles.size());
}

void density_sweep(benchmark::State& state) {
    Simulation& s = dam(state);
    for (auto _ : state) compute_density(s.particles, s.neighbours, s.walls, s.problem.smoothing, s.sweep);
    report(state, s);
}

void density_sweep_without_walls(benchmark::State& state) {
    Simulation& s = dam(state);
    const Walls none;
    for (auto _ : state) compute_density(s.particles, s.neighbours, none, s.problem.smoothing, s.sweep);
    report(state, s);
}

void bare_reference(benchmark::State& state) {
    Simulation& s = dam(state);
    const Poly6 kernel = s.problem.smoothing.density;
    const auto& x = s.particles.position;
    for (auto _ : state) {
        for (std::size_t i = 0; i < x.size(); ++i) {
            Real sum = s.particles.mass[i] * kernel.value(0);
            for (const Index j : s.neighbours[i])
                sum += s.particles.mass[j] * kernel.value((x[i] - x[j]).squaredNorm());
            s.particles.density[i] = sum;
        }
    }
    report(state, s);
}

BENCHMARK(density_sweep)->Arg(200)->Unit(benchmark::kMillisecond);
BENCHMARK(density_sweep_without_walls)->Arg(200)->Unit(benchmark::kMillisecond);
BENCHMARK(bare_reference)->Arg(200)->Unit(benchmark::kMillisecond);
BENCHMARK(density_sweep)->Arg(217)->Unit(benchmark::kMillisecond);
BENCHMARK(density_sweep_without_walls)->Arg(217)->Unit(benchmark::kMillisecond);
BENCHMARK(bare_reference)->Arg(217)->Unit(benchmark::kMillisecond);

}  // namespace
