// Makes 500 000 surfels ready for rays, as every frame does, on all threads. Blended surfels (sort, pack, build) and
// Embree's oriented discs (copy, build) take turns. Counters: milliseconds of wall time of each, the best of all turns,
// and their ratio.
#include <benchmark/benchmark.h>

#include <optional>

#include "pipeline/base/timer.h"
#include "render/ray_scene.h"
#include "tests/bench/native_discs.h"
#include "tests/render/surfel_shapes.h"

namespace {

using namespace thixo;
using namespace thixo::render;

void commit(benchmark::State& state) {
    double native_best = 1e30, best = 1e30;
    int turn = 0;
    for (auto _ : state) {
        // Places differ every time, as in an animation.
        const SurfelCloud cloud = shapes::sphere(500000, 1.03f, {0.01f * float(turn++ % 7), 0, 0}, 0.2f);
        std::optional<bench::NativeDiscs> native;
        double begin = wall_seconds();
        native.emplace(cloud);
        native_best = std::min(native_best, wall_seconds() - begin);
        native.reset();
        SurfelSet set = shapes::one_object(cloud);
        std::optional<RayScene> scene;
        begin = wall_seconds();
        scene.emplace(std::move(set), std::vector<MeshObject>());
        const double own = wall_seconds() - begin;
        best = std::min(best, own);
        state.SetIterationTime(own);
    }
    state.counters["native_ms"] = 1e3 * native_best;
    state.counters["surfels_ms"] = 1e3 * best;
    state.counters["ratio"] = native_best / best;
}

BENCHMARK(commit)->Unit(benchmark::kMillisecond)->UseManualTime();

}  // namespace
