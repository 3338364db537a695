// An update of the animated surface on two threads, beside the figure of the dissertation (6.7): 1.3 s for an iteration
// of 3.4 thousand surfels. `times_published` is how many times as fast an update is here, both taken per surfel.
#include <benchmark/benchmark.h>

#include "tests/bench/sim_fixture.h"

namespace {

using namespace thixo;

constexpr double kPublishedSeconds = 1.3, kPublishedSurfels = 3400;

/// A pool in a tank, four particles deep, after half a second.
Simulation settled_pool() {
    scene::Scene scene = fixture::tank({0.13, 0.13, 0.2}, 0.04, 0.01);
    scene.frames.fps = 2;
    Simulation s = make_simulation(scene);
    advance_frame(s);
    return s;
}

/// The dam of the other benchmarks in its flight against the far wall.
Simulation splash() { return fixture::fallen_dam(2'000); }

/// Advances frame by frame and counts the time of the surface alone.
void update(benchmark::State& state, Simulation s) {
    s.problem.scene.surface.enabled = true;
    refresh_surface(s);
    s.problem.scene.frames.fps = 48;
    s.clock.frame =
        static_cast<int>(std::ceil(s.clock.time * s.problem.scene.frames.fps)) + s.problem.scene.frames.first;
    double updates = 0, surfels = 0, seconds = 0;
    for (auto _ : state) {
        s.stats = StepStats{};
        advance_frame(s);
        state.SetIterationTime(s.stats.surface_seconds / s.stats.surface_updates);
        updates += s.stats.surface_updates;
        surfels += s.stats.surface_updates * static_cast<double>(s.surface.size());
        seconds += s.stats.surface_seconds;
    }
    state.counters["surfels"] = surfels / updates;
    state.counters["us_per_surfel"] = 1e6 * seconds / surfels;
    state.counters["times_published"] = kPublishedSeconds / kPublishedSurfels / (seconds / surfels);
}

void pool_update(benchmark::State& state) {
    set_thread_count(2);
    update(state, settled_pool());
}
void splash_update(benchmark::State& state) {
    set_thread_count(2);
    update(state, splash());
}

// The pool goes on for as long as it likes; the splash is over within half a second.
BENCHMARK(pool_update)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(24);
BENCHMARK(splash_update)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(12);

}  // namespace
