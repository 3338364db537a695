// Making 500 000 surfels ready for rays, as every frame does: blended surfels (sort, pack, build) beside Embree's
// oriented discs (copy, build).
#include <benchmark/benchmark.h>

#include "render/ray_scene.h"
#include "tests/bench/native_discs.h"
#include "tests/render/surfel_shapes.h"

namespace {

using namespace thixo;
using namespace thixo::render;

SurfelCloud moved_sphere() { return shapes::sphere(500000, 1.03f, {0.06f, 0, 0}, 0.2f); }

void native(benchmark::State& state) {
    const SurfelCloud cloud = moved_sphere();
    for (auto _ : state) {
        const bench::NativeDiscs discs(cloud);
        benchmark::DoNotOptimize(&discs);
    }
}

void blended(benchmark::State& state) {
    const SurfelCloud cloud = moved_sphere();
    for (auto _ : state) {
        state.PauseTiming();
        SurfelSet set = shapes::one_object(cloud);
        state.ResumeTiming();
        const RayScene scene(std::move(set), {});
        benchmark::DoNotOptimize(&scene);
    }
}

BENCHMARK(native)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(blended)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
