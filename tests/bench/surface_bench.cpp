// An update of the animated surface beside the figure of the dissertation (6.7). That is 1.3 s for an iteration of 3.4
// thousand surfels around 3 thousand particles poured into a glass. `times_published` is how many times as fast an
// update is here, both per surfel; the aim is 50. The argument is the number of threads; `cpu` is the processor time of
// an update [ms].
#include <benchmark/benchmark.h>

#include <ctime>

#include "pipeline/contract/scene_io.h"
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

/// Fig. 6.10 while it splashes, with 2 500 particles.
Simulation glass() {
    Simulation s = make_simulation(scene::load_scene(THIXO_SOURCE_DIR "/configs/thesis/fig_6_10_pour.yaml"));
    s.problem.scene.surface.enabled = false;
    while (s.clock.frame < 84) advance_frame(s);
    return s;
}

double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Gives a simulation that ran without a surface one, made in its present state.
void begin_surface(Simulation& s) {
    s.problem.scene.surface.enabled = true;
    s.particles.has.surface = true;
    resize_table(s.particles, s.particles.size());
    s.particles.surface_position = s.particles.position;
    refresh_surface(s);
}

/// A copy of the state at each frame, updated again and again.
void update_still(benchmark::State& state, Simulation s) {
    begin_surface(s);
    s.problem.scene.surface.enabled = false;
    const scene::Surface& params = s.problem.scene.surface;
    double surfels = 0, cpu = 0;
    for (auto _ : state) {
        state.PauseTiming();
        advance_frame(s);
        state.ResumeTiming();
        const double before = cpu_seconds();
        update_surface(s.surface, s.particles,
                       {s.walls, params, s.problem.smoothing.spacing, s.problem.smoothing.support, {}});
        cpu += cpu_seconds() - before;
        surfels += static_cast<double>(s.surface.size());
    }
    const double updates = static_cast<double>(state.iterations());
    state.counters["surfels"] = surfels / updates;
    state.counters["cpu"] = 1e3 * cpu / updates;
    state.counters["us_per_surfel"] = 1e6 * cpu / surfels;
    state.counters["ms_for_3400"] = 1e3 * kPublishedSurfels * cpu / surfels;
    state.counters["times_published"] = kPublishedSeconds / kPublishedSurfels / (cpu / surfels);
}

/// Advances frame by frame and counts the time of the surface alone.
void update(benchmark::State& state, Simulation s) {
    begin_surface(s);
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

void glass_update(benchmark::State& state) {
    set_thread_count(static_cast<int>(state.range(0)));
    update_still(state, glass());
}

BENCHMARK(glass_update)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(18);
// The pool moves for long; the splash is over within half a second.
BENCHMARK(pool_update)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(24);
BENCHMARK(splash_update)->Unit(benchmark::kMillisecond)->UseManualTime()->Iterations(12);

}  // namespace
