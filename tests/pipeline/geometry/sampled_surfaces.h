// Surfaces known exactly, sampled evenly: what tests of surfels measure against.
#pragma once

#include <cmath>
#include <vector>

#include "pipeline/base/math.h"

namespace thixo::fixture {

struct Samples {
    std::vector<Vec3> position, normal;
    double spacing = 0;  // mean distance of neighbours [m]
};

/// n points on a sphere along a golden spiral (Vogel 1979).
inline Samples sphere(int n, double radius, const Vec3& centre = Vec3(0, 0, 0)) {
    Samples s;
    s.spacing = std::sqrt(4 * kPi * radius * radius / n);
    for (int i = 0; i < n; ++i) {
        const double z = 1 - (2 * i + 1.0) / n, ring = std::sqrt(1 - z * z), angle = i * kPi * (3 - std::sqrt(5.0));
        const Vec3d normal(ring * std::cos(angle), ring * std::sin(angle), z);
        s.normal.push_back(normal.cast<Real>());
        s.position.push_back(centre + (radius * normal).cast<Real>());
    }
    return s;
}

/// Points `spacing` apart on a torus about the z axis: circles around the tube, each with its own number of points.
inline Samples torus(double spacing, double radius, double tube) {
    Samples s;
    s.spacing = spacing;
    const int circles = static_cast<int>(2 * kPi * tube / spacing + 0.5);
    for (int c = 0; c < circles; ++c) {
        const double v = 2 * kPi * c / circles, ring = radius + tube * std::cos(v);
        const int count = static_cast<int>(2 * kPi * ring / spacing + 0.5);
        for (int k = 0; k < count; ++k) {
            const double u = 2 * kPi * (k + 0.5 * (c % 2)) / count;
            const Vec3d normal(std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v));
            s.position.push_back((Vec3d(radius * std::cos(u), radius * std::sin(u), 0) + tube * normal).cast<Real>());
            s.normal.push_back(normal.cast<Real>());
        }
    }
    return s;
}

}  // namespace thixo::fixture
