// Blended surfel hits beside bare rtcIntersect1 on Embree's oriented discs: the same surfels and rays, on one thread,
// in turns. Counters: million rays a second of each, and their ratio.
#include <benchmark/benchmark.h>

#include "tests/bench/gather_designs.h"
#include "tests/bench/native_discs.h"
#include "tests/bench/ray_sets.h"

namespace {

using namespace thixo;
using namespace thixo::bench;
using render::Hit;
using render::RayScene;
using render::SurfelSet;

constexpr std::size_t kSurfels = 500000;
constexpr int kRays = 1 << 17;

template <class Ours>
void compare(benchmark::State& state, const std::vector<Ray>& rays, const NativeDiscs& native, Ours&& ours) {
    double reference = 0, own = 0;
    std::size_t native_hits = 0, hits = 0;
    const auto bare = [&](const Ray& ray) {
        float t;
        return native.intersect(ray.origin, ray.direction, t);
    };
    for (auto _ : state) {
        const double a = seconds_of(rays, bare, native_hits), b = seconds_of(rays, ours, hits);
        reference += a;
        own += b;
        state.SetIterationTime(b);
    }
    const double all = double(state.iterations()) * double(rays.size());
    state.counters["native"] = 1e-6 * all / reference;
    state.counters["surfels"] = 1e-6 * all / own;
    state.counters["ratio"] = reference / own;
    state.counters["hit_share"] = double(hits) / all;
}

void compare_scene(benchmark::State& state, const std::vector<Ray>& rays, const NativeDiscs& native,
                   const RayScene& scene) {
    compare(state, rays, native, [&](const Ray& ray) {
        Hit hit;
        return scene.intersect(ray, {}, hit);
    });
}

const SurfelCloud& ball() {
    static const SurfelCloud c = shapes::sphere(kSurfels, 1, Vec3f::Zero(), 0.2f);
    return c;
}
const NativeDiscs& native_ball() {
    static const NativeDiscs discs(ball());
    return discs;
}
const RayScene& blended_ball() {
    static const RayScene scene(shapes::one_object(ball()), {});
    return scene;
}

void blended_primary(benchmark::State& state) {
    compare_scene(state, primary_rays(kRays), native_ball(), blended_ball());
}
void blended_crossing(benchmark::State& state) {
    compare_scene(state, crossing_rays(kRays), native_ball(), blended_ball());
}
void blended_bounce(benchmark::State& state) {
    const SurfelCloud cloud = room(kSurfels);
    const NativeDiscs native(cloud);
    const RayScene scene(shapes::one_object(cloud), {});
    compare_scene(state, bounce_rays(kRays, cloud.axis1[0].norm()), native, scene);
}

TrimNode all_of(int sheets) {
    TrimNode tree{TrimNode::Op::all, 0, {}};
    for (int k = 0; k < sheets; ++k) tree.parts.push_back({TrimNode::Op::sheet, k, {}});
    return tree;
}

/// A square of discs about offset * normal, as sheet `sheet`.
void add_plane(SurfelSet& set, std::uint32_t sheet, const Vec3f& normal, float offset, float half, float step) {
    Vec3f a, b;
    orthonormal_basis(normal, a, b);
    for (float u = -half; u < half; u += step)
        for (float v = -half; v < half; v += step) {
            shapes::add_disc(set.cloud, offset * normal + u * a + v * b, normal, step);
            set.layer.push_back(sheet);
        }
}

/// A cube of six sheets that extend beyond its edges.
SurfelSet cube() {
    SurfelSet set;
    constexpr float half = 0.65f, step = 2 * half / 285;
    for (int k = 0; k < 6; ++k)
        add_plane(set, std::uint32_t(k), (k % 2 == 0 ? 1.0f : -1.0f) * Vec3f::Unit(k / 2), half, half + 2 * step, step);
    set.object.assign(6, 0);
    set.trim = {all_of(6)};
    return set;
}

/// The ball without the part beyond a slanting plane.
SurfelSet cut_ball() {
    SurfelSet set;
    set.cloud = shapes::sphere(kSurfels * 4 / 5, 1, Vec3f::Zero(), 0.2f);
    set.layer.assign(set.cloud.size(), 0);
    add_plane(set, 1, Vec3f(0.6f, -0.7f, 0.3f).normalized(), 0.3f, 1, 0.0056f);
    set.object.assign(2, 0);
    set.trim = {all_of(2)};
    return set;
}

void trimmed(benchmark::State& state, SurfelSet set, const std::vector<Ray>& rays) {
    const NativeDiscs native(set.cloud);
    const RayScene scene(std::move(set), {});
    compare_scene(state, rays, native, scene);
}
/// The rays seen from an oblique direction.
std::vector<Ray> turned(std::vector<Ray> rays) {
    const Mat3f turn =
        (Eigen::AngleAxisf(0.5f, Vec3f::UnitX()) * Eigen::AngleAxisf(0.7f, Vec3f::UnitZ())).toRotationMatrix();
    for (Ray& ray : rays) {
        ray.origin = turn * ray.origin;
        ray.direction = (turn * ray.direction).normalized();
    }
    return rays;
}
void trimmed_primary(benchmark::State& state) { trimmed(state, cube(), turned(primary_rays(kRays))); }
void trimmed_crossing(benchmark::State& state) { trimmed(state, cube(), crossing_rays(kRays)); }
void trimmed_curved(benchmark::State& state) { trimmed(state, cut_ball(), primary_rays(1 << 10)); }

/// The first way to collect surfels, without their blend: discs with a filter.
void filter_gather(benchmark::State& state, const std::vector<Ray>& rays) {
    const FilterGather discs(ball());
    compare(state, rays, native_ball(), [&](const Ray& ray) {
        FilterGather::Query query;
        return discs.gather(ray.origin, ray.direction, query) > 0;
    });
}
void filter_primary(benchmark::State& state) { filter_gather(state, primary_rays(kRays)); }
void filter_crossing(benchmark::State& state) { filter_gather(state, crossing_rays(kRays)); }

/// The second way: blocks of eight.
void block_gather(benchmark::State& state, const std::vector<Ray>& rays) {
    const BlockGather blocks(ball());
    compare(state, rays, native_ball(), [&](const Ray& ray) { return blocks.gather(ray) > 0; });
}
void blocks_primary(benchmark::State& state) { block_gather(state, primary_rays(kRays)); }
void blocks_crossing(benchmark::State& state) { block_gather(state, crossing_rays(kRays)); }

#define THIXO_RAYS(name) BENCHMARK(name)->Unit(benchmark::kMillisecond)->UseManualTime()
THIXO_RAYS(blended_primary);
THIXO_RAYS(blended_bounce);
THIXO_RAYS(blended_crossing);
THIXO_RAYS(trimmed_primary);
THIXO_RAYS(trimmed_crossing);
THIXO_RAYS(trimmed_curved);
THIXO_RAYS(filter_primary);
THIXO_RAYS(filter_crossing);
THIXO_RAYS(blocks_primary);
THIXO_RAYS(blocks_crossing);

}  // namespace
