// Clouds and rays of the surfel benchmarks.
#pragma once

#include <immintrin.h>
#include <time.h>

#include <vector>

#include "tests/render/surfel_shapes.h"

namespace thixo::bench {

using render::Ray;
namespace shapes = render::shapes;

/// Processor time of this thread, in which other programs do not count.
inline double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// Seconds for all rays; `hits` counts those that hit.
template <class Trace>
double seconds_of(const std::vector<Ray>& rays, Trace&& trace, std::size_t& hits) {
    _mm_setcsr(_mm_getcsr() | 0x8040);  // flush denormals, as the renderer does
    const double begin = cpu_seconds();
    for (const Ray& ray : rays) hits += trace(ray);
    return cpu_seconds() - begin;
}

/// Primary rays in tiles of 8 x 8 pixels, of a picture that a unit sphere nearly fills.
inline std::vector<Ray> primary_rays(int count) {
    std::vector<Ray> rays;
    const int side = int(std::sqrt(double(count))) / 8 * 8;
    for (int tile = 0; tile < side * side / 64; ++tile)
        for (int pixel = 0; pixel < 64; ++pixel) {
            const int across = side / 8;
            const float x = float(tile % across * 8 + pixel % 8) / float(side) - 0.5f,
                        y = float(tile / across * 8 + pixel / 8) / float(side) - 0.5f;
            rays.push_back({{0, -4, 0}, Vec3f(0.55f * x, 1, 0.55f * y).normalized()});
        }
    return rays;
}

/// Rays from a sphere of radius 2 to points within the unit sphere.
inline std::vector<Ray> crossing_rays(int count) {
    std::vector<Ray> rays;
    for (std::uint64_t i = 0; i < std::uint64_t(count); ++i) {
        const Vec3f from = 2 * shapes::on_sphere(i, 0),
                    to = shapes::on_sphere(i, 1) * float(std::cbrt(random_unit(1, i, 2, 0)));
        rays.push_back({from, (to - from).normalized()});
    }
    return rays;
}

/// Diffuse bounces within a round room of radius 1, from random places at the distance `lift` from its wall.
inline std::vector<Ray> bounce_rays(int count, float lift) {
    std::vector<Ray> rays;
    for (std::uint64_t i = 0; i < std::uint64_t(count); ++i) {
        const Vec3f at = shapes::on_sphere(i, 0);
        // Points are even on the unit sphere around the normal's end, which gives directions by the cosine.
        rays.push_back({(1 - lift) * at, (-at + 0.999f * shapes::on_sphere(i, 1)).normalized()});
    }
    return rays;
}

/// The room: a sphere that faces inward.
inline SurfelCloud room(std::size_t n) {
    SurfelCloud cloud = shapes::sphere(n, 1, Vec3f::Zero(), 0.2f);
    std::swap(cloud.axis1, cloud.axis2);
    for (Vec3f& normal : cloud.normal) normal = -normal;
    return cloud;
}

/// A wavy sheet with a ball over it, about n surfels.
inline SurfelCloud sheet_and_ball(std::size_t n) {
    SurfelCloud cloud = shapes::sphere(n / 5, 0.35f, {0, 0, 0.5f}, 0.2f);
    const int side = int(std::sqrt(0.8 * double(n)));
    const float step = 3.0f / float(side);
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const float x = (float(i) + 0.5f) * step - 1.5f, y = (float(j) + 0.5f) * step - 1.5f;
            const Vec3f slope(-0.32f * std::cos(8 * x) * std::cos(6 * y), 0.24f * std::sin(8 * x) * std::sin(6 * y), 1);
            shapes::add_disc(cloud, {x, y, 0.04f * std::sin(8 * x) * std::cos(6 * y)}, slope.normalized(), 1.1f * step);
        }
    return cloud;
}

}  // namespace thixo::bench
