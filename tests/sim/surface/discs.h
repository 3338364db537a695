// Tells which rays meet a cloud of discs.
#pragma once

#include "pipeline/base/random.h"
#include "pipeline/geometry/point_grid.h"
#include "pipeline/geometry/surfel.h"

namespace thixo::fixture {

/// The longest half-axis of a cloud [m].
inline double widest(const SurfelCloud& cloud) {
    Real longest = 0;
    for (const auto* axes : {&cloud.axis1, &cloud.axis2})
        for (const Vec3& axis : *axes) longest = std::max(longest, axis.norm());
    return static_cast<double>(longest);
}

class Discs {
  public:
    /// No axis is longer than `radius` [m].
    Discs(const SurfelCloud& cloud, double radius) : cloud_(cloud), radius_(radius) {
        grid_.build(cloud.position, Real(2 * radius));
    }

    bool hit(const Vec3& origin, const Vec3& direction, double length) const {
        // Discs about points within a radius of the ray: balls half a radius apart along it hold them.
        for (double t = 0; t < length; t += radius_) {
            bool found = false;
            grid_.for_each_neighbour(origin + Real(t) * direction, Real(1.2 * radius_),
                                     [&](Index i, Real) { found = found || crosses(i, origin, direction); });
            if (found) return true;
        }
        return false;
    }

  private:
    bool crosses(Index i, const Vec3& origin, const Vec3& direction) const {
        const Real rate = direction.dot(cloud_.normal[i]);
        if (rate == 0) return false;
        const Real t = (cloud_.position[i] - origin).dot(cloud_.normal[i]) / rate;
        if (t <= 0) return false;
        const Vec3 offset = origin + t * direction - cloud_.position[i];
        // The axes need not be at right angles: offset = u a + v b.
        const Vec3 &a = cloud_.axis1[i], &b = cloud_.axis2[i];
        const Real aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b), pa = offset.dot(a), pb = offset.dot(b);
        const Real det = aa * bb - ab * ab;
        return square(pa * bb - pb * ab) + square(pb * aa - pa * ab) <= square(det);
    }
    const SurfelCloud& cloud_;
    double radius_;
    PointGrid grid_;
};

/// The k-th of many directions, even over the sphere.
inline Vec3 random_direction(std::size_t k) {
    const double z = 2 * random_unit(7, k, 0, 0) - 1, angle = 2 * kPi * random_unit(7, k, 0, 1),
                 ring = std::sqrt(1 - z * z);
    return {Real(ring * std::cos(angle)), Real(ring * std::sin(angle)), Real(z)};
}

}  // namespace thixo::fixture
