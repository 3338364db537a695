// Blended surfel hits beside bare rtcIntersect1 on Embree's oriented discs: the same surfels, the same rays, one
// thread.
#include <benchmark/benchmark.h>
#include <immintrin.h>

#include "render/ray_scene.h"
#include "tests/bench/native_discs.h"
#include "tests/render/surfel_shapes.h"

namespace {

using namespace thixo;
using namespace thixo::render;

constexpr std::size_t kSurfels = 500000;
constexpr int kRays = 1 << 18;

const SurfelCloud& cloud() {
    static const SurfelCloud c = shapes::sphere(kSurfels, 1, Vec3f::Zero(), 0.2f);
    return c;
}

std::vector<Ray> primary() {  // 8 x 8 pixel tiles of a picture that the sphere about fills
    std::vector<Ray> rays;
    for (int tile = 0; tile < kRays / 64; ++tile)
        for (int pixel = 0; pixel < 64; ++pixel) {
            const float x = float(tile % 64 * 8 + pixel % 8) / 512 - 0.5f,
                        y = float(tile / 64 * 8 + pixel / 8) / 512 - 0.5f;
            rays.push_back({{0, -4, 0}, Vec3f(0.55f * x, 1, 0.55f * y).normalized()});
        }
    return rays;
}

std::vector<Ray> incoherent() {  // from a sphere of radius 2 to points within the surfels' sphere
    std::vector<Ray> rays;
    for (std::uint64_t i = 0; i < kRays; ++i) {
        const Vec3f from = 2 * shapes::on_sphere(i, 0),
                    to = shapes::on_sphere(i, 1) * float(std::cbrt(random_unit(1, i, 2, 0)));
        rays.push_back({from, (to - from).normalized()});
    }
    return rays;
}

template <class Trace>
void run(benchmark::State& state, const std::vector<Ray>& rays, Trace&& trace) {
    _mm_setcsr(_mm_getcsr() | 0x8040);  // flush denormals, as the renderer does
    std::size_t hits = 0;
    for (auto _ : state)
        for (const Ray& ray : rays) hits += trace(ray);
    state.SetItemsProcessed(std::int64_t(state.iterations()) * std::int64_t(rays.size()));
    state.counters["hit_share"] = double(hits) / double(state.iterations()) / double(rays.size());
}

void native(benchmark::State& state, const std::vector<Ray>& rays) {
    static const bench::NativeDiscs discs(cloud());
    run(state, rays, [&](const Ray& ray) {
        float t;
        return discs.intersect(ray.origin, ray.direction, t);
    });
}

void blended(benchmark::State& state, const std::vector<Ray>& rays) {
    static const RayScene scene(shapes::one_object(cloud()), {});
    run(state, rays, [&](const Ray& ray) {
        Hit hit;
        return scene.intersect(ray, {}, hit);
    });
}

BENCHMARK_CAPTURE(native, primary, primary())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(blended, primary, primary())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(native, incoherent, incoherent())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(blended, incoherent, incoherent())->Unit(benchmark::kMillisecond);

}  // namespace
