// A whole step of the `eos` solver, on one thread. The reference of the same run is one bare sweep over the same
// neighbour lists: read a step's time in such sweeps, which does not depend on the machine's mood, and items/s
// (particle-steps a second).
#include <benchmark/benchmark.h>

#include "tests/bench/sim_fixture.h"

namespace {

using namespace thixo;

Simulation& dam() {
    static Simulation s = [] {
        set_thread_count(1);
        return fixture::fallen_dam(100'000);
    }();
    return s;
}

void eos_step(benchmark::State& state) {
    Simulation& s = dam();
    s.stats = StepStats{};
    for (auto _ : state) {
        s.clock.next_frame = s.clock.time + 0.1;
        step(s);
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(s.particles.size()));
    const auto milliseconds = [&](double seconds) { return 1e3 * seconds / static_cast<double>(s.stats.steps); };
    state.counters["neighbours_ms"] = milliseconds(s.stats.neighbours_seconds);
    state.counters["density_ms"] = milliseconds(s.stats.density_seconds);
    state.counters["forces_ms"] = milliseconds(s.stats.forces_seconds);
    state.counters["integration_ms"] = milliseconds(s.stats.integration_seconds);
    state.counters["neighbours"] = static_cast<double>(s.stats.pairs) / static_cast<double>(s.stats.particle_steps);
}

void bare_sweep(benchmark::State& state) {
    Simulation& s = dam();
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

BENCHMARK(eos_step)->Unit(benchmark::kMillisecond);
BENCHMARK(bare_sweep)->Unit(benchmark::kMillisecond);

}  // namespace
