// The closed surface at the number of rays a film sends.
#include <gtest/gtest.h>

#include "pipeline/base/parallel.h"
#include "tests/render/surfel_shapes.h"

namespace thixo::render {
namespace {

using shapes::on_sphere;

struct Counts {
    std::int64_t holes = 0, lost = 0;
    Counts operator+(const Counts& b) const { return {holes + b.holes, lost + b.lost}; }
};

/// One ray from outside through the unit ball; where it meets the surface it goes on inside, refracted as into water.
Counts follow(const RayScene& scene, std::uint64_t i) {
    const Vec3f from = 3 * on_sphere(i, 5), to = on_sphere(i, 6) * float(0.999 * std::cbrt(random_unit(1, i, 7, 0)));
    const Ray ray{from, (to - from).normalized()};
    Hit hit;
    if (!scene.intersect(ray, {}, hit)) return {1, 0};
    const Vec3f refracted = shapes::refracted_into_water(hit, ray.direction);
    Interior inside;
    inside.add(0);
    Hit out;
    return {0, !scene.intersect({pass(hit, ray.direction), refracted}, inside, out)};
}

Counts follow_all(const SurfelCloud& cloud, std::size_t rays) {
    const RayScene scene(shapes::one_object(cloud), {});
    return parallel_sum<Counts>(
        rays, [&](std::size_t i) { return follow(scene, i); }, Counts{});
}

TEST(SurfelBlend, TenMillionRaysFindNoHoleInASphereAndEachThatEntersLeaves) {
    const Counts counts = follow_all(shapes::sphere(5000, 1, Vec3f::Zero(), 0.3f), 10'000'000);
    EXPECT_EQ(counts.holes, 0);
    EXPECT_EQ(counts.lost, 0);
}

}  // namespace
}  // namespace thixo::render
