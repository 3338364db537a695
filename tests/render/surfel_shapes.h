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

/// One object (0) of one layer.
inline SurfelSet one_object(SurfelCloud cloud) {
    SurfelSet set;
    set.layer.assign(cloud.size(), 0);
    set.object = {0};
    set.cloud = std::move(cloud);
    return set;
}

}  // namespace thixo::render::shapes
