// Surfel clouds of known surfaces, for tests and benchmarks.
#pragma once

#include <cmath>

#include "pipeline/base/random.h"
#include "pipeline/geometry/surfel.h"
#include "render/ray_scene.h"

namespace thixo::render::shapes {

inline void add_disc(SurfelCloud& cloud, const Vec3f& position, const Vec3f& normal, float radius) {
    Vec3f a, b;
    orthonormal_basis(normal, a, b);
    cloud.position.push_back(position);
    cloud.axis1.push_back(a * radius);
    cloud.axis2.push_back(b * radius);
    cloud.normal.push_back(normal);
}

/// n points even on the unit sphere (Fibonacci lattice).
inline Vec3f fibonacci(std::size_t i, std::size_t n) {
    const double z = 1 - (2.0 * double(i) + 1) / double(n), phi = double(i) * kPi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return Vec3d(r * std::cos(phi), r * std::sin(phi), z).cast<float>();
}

/// Random direction i of stream `use`, even on the sphere.
inline Vec3f on_sphere(std::uint64_t i, std::uint64_t use) {
    const double z = 2 * random_unit(1, i, use, 0) - 1, phi = 2 * kPi * random_unit(1, i, use, 1),
                 r = std::sqrt(1 - z * z);
    return Vec3d(r * std::cos(phi), r * std::sin(phi), z).cast<float>();
}

/// Mean distance of n points even on an area: each has a square of this edge.
inline float even_spacing(double area, std::size_t n) { return float(std::sqrt(area / double(n))); }

/// A sphere of n surfels whose radius is their mean distance: every point is under three discs on average.
inline SurfelCloud sphere(std::size_t n, float radius = 1, const Vec3f& centre = Vec3f::Zero(), float jitter = 0) {
    SurfelCloud cloud;
    const float r = even_spacing(4 * kPi, n) * radius;
    for (std::size_t i = 0; i < n; ++i) {
        Vec3f p = fibonacci(i, n);
        const auto random = [&](int use) {
            return jitter * r / radius * float(2 * random_unit(7, i, 0, std::uint64_t(use)) - 1);
        };
        if (jitter > 0) p = (p + Vec3f(random(0), random(1), random(2))).normalized();
        add_disc(cloud, centre + radius * p, p, r);
    }
    return cloud;
}

/// A plane of about n surfels whose radii grow with the distance from the origin, from 1e-5 m to 1 m. Its rings grow by
/// a constant factor. A ring at distance x has surfels of radius kGradedSlope x.
inline constexpr double kGradedSlope = 0.02;
inline SurfelCloud graded_plane(std::size_t n) {
    SurfelCloud cloud;
    const double rings = std::sqrt(double(n) * std::log(1e5) / (2 * kPi)), per_ring = double(n) / rings;
    const double growth = std::pow(1e5, 1 / rings), first = 1e-5 / kGradedSlope;
    const double cover = 1.2 * (growth - 1) / kGradedSlope;  // radii as large as the rings are apart, and a little more
    for (int ring = 0; ring < int(rings); ++ring) {
        const double x = first * std::pow(growth, ring);
        for (int i = 0; i < int(per_ring); ++i) {
            const double a = 2 * kPi * (i + 0.5 * (ring & 1)) / per_ring;
            add_disc(cloud, Vec3d(x * std::cos(a), x * std::sin(a), 0).cast<float>(), {0, 0, 1},
                     float(cover * kGradedSlope * x));
        }
    }
    return cloud;
}

/// A square of edge 1 m about the origin with side x side surfels.
inline SurfelCloud even_plane(int side) {
    SurfelCloud cloud;
    for (int k = 0; k < side * side; ++k)
        add_disc(cloud,
                 {(float(k % side) + 0.5f) / float(side) - 0.5f, (float(k / side) + 0.5f) / float(side) - 0.5f, 0},
                 {0, 0, 1}, 1.2f / float(side));
    return cloud;
}

/// Slanting rays down to the plane z = 0. graded: to all sizes of graded_plane alike, else to even_plane.
inline std::vector<Ray> rays_down(int count, bool graded) {
    std::vector<Ray> rays;
    for (std::uint64_t i = 0; i < std::uint64_t(count); ++i) {
        const double u = random_unit(3, i, 0, 0), v = random_unit(3, i, 0, 1);
        const double x = 2e-5 / kGradedSlope * std::pow(5e4 / 2, u);
        const Vec3f at = (graded ? Vec3d(x * std::cos(2 * kPi * v), x * std::sin(2 * kPi * v), 0)
                                 : Vec3d(0.9 * (u - 0.5), 0.9 * (v - 0.5), 0))
                             .cast<float>();
        const Vec3f down =
            Vec3f(float(random_unit(3, i, 1, 0)) - 0.5f, float(random_unit(3, i, 1, 1)) - 0.5f, -1).normalized();
        rays.push_back({at - (0.1f + at.norm()) * down, down});
    }
    return rays;
}

/// A torus about z (ring radius R, tube radius a): n surfels by area.
inline SurfelCloud torus(std::size_t n, float R, float a) {
    SurfelCloud cloud;
    const float r = even_spacing(4 * kPi * kPi * double(R) * double(a), n);
    const int rows = std::max(3, int(std::lround(2 * kPi * a / r)));
    for (int j = 0; j < rows; ++j) {
        const float v = float(2 * kPi * j / rows), ring = R + a * std::cos(v);
        const int columns = std::max(3, int(std::lround(2 * kPi * ring / r)));
        for (int i = 0; i < columns; ++i) {
            const float u = float(2 * kPi * (i + 0.5 * (j % 2)) / columns);
            const Vec3f out(std::cos(u), std::sin(u), 0);
            add_disc(cloud, ring * out + Vec3f(0, 0, a * std::sin(v)), std::cos(v) * out + Vec3f(0, 0, std::sin(v)), r);
        }
    }
    return cloud;
}

/// The direction a ray takes into a medium of index 1.33 behind the hit.
inline Vec3f refracted_into_water(const Hit& hit, const Vec3f& direction) {
    const float cosine = -hit.normal.dot(direction), eta = 1 / 1.33f;
    return (eta * direction + (eta * cosine - std::sqrt(1 - eta * eta * (1 - cosine * cosine))) * hit.normal)
        .normalized();
}

/// Whether a ray that has met `hit` of object 0 comes out again: it does not if it crosses an odd number of times.
inline bool stays_inside(const RayScene& scene, Ray ray, Hit hit, Interior interior) {
    for (int crossings = 1; crossings <= 32; ++crossings) {
        hit.entering ? interior.add(0) : interior.remove(0);
        ray.origin = pass(hit, ray.direction);
        if (!scene.intersect(ray, interior, hit)) return crossings % 2;
    }
    return false;
}

/// One object (0) of one layer.
inline SurfelSet one_object(SurfelCloud cloud) {
    SurfelSet set;
    set.layer.assign(cloud.size(), 0);
    set.object = {0};
    set.cloud = std::move(cloud);
    return set;
}

}  // namespace thixo::render::shapes
