// Rays from deep inside a liquid, and liquids in vessels to send them through.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/point_grid.h"
#include "tests/sim/surface/liquid_fixture.h"

namespace thixo::fixture {

class Discs {
  public:
    explicit Discs(const SurfelCloud& cloud) : cloud_(cloud) { grid_.build(cloud.position, Real(kSpacing)); }

    bool hit(const Vec3& origin, const Vec3& direction, double length) const {
        // Discs of half a spacing about points within half a spacing of the ray: balls a quarter of a spacing apart
        // along it hold them.
        for (double t = 0; t < length; t += 0.5 * kSpacing) {
            bool found = false;
            grid_.for_each_neighbour(origin + Real(t) * direction, Real(0.6 * kSpacing),
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
        const Vec3 &a = cloud_.axis1[i], &b = cloud_.axis2[i];
        return square(offset.dot(a) / a.squaredNorm()) + square(offset.dot(b) / b.squaredNorm()) <= 1;
    }
    const SurfelCloud& cloud_;
    PointGrid grid_;
};

/// Rays from the particles that `deep` picks; the number of those that leave the liquid unseen.
inline int holes(const std::vector<Vec3>& places, int rays, const std::function<bool(const Vec3&)>& deep) {
    Particles p = liquid(places);
    SurfaceState s;
    for (int k = 0; k < 3; ++k) update(s, p);
    std::vector<Vec3> from;
    for (const Vec3& x : p.position)
        if (deep(x)) from.push_back(x);
    EXPECT_GT(from.size(), 10u);
    const Discs discs(s.surfels);
    return static_cast<int>(parallel_sum(static_cast<std::size_t>(rays), [&](std::size_t k) {
        const double z = 2 * random_unit(7, k, 0, 0) - 1, angle = 2 * kPi * random_unit(7, k, 0, 1),
                     ring = std::sqrt(1 - z * z);
        const Vec3 direction(Real(ring * std::cos(angle)), Real(ring * std::sin(angle)), Real(z));
        const Vec3& x = from[random_bits(7, k, 0, 2) % from.size()];
        return discs.hit(x, direction, 40 * kSpacing) ? 0.0 : 1.0;
    }));
}

/// Liquid at rest between walls: distance to them, places of its particles, and which of these are deep inside.
struct Vessel {
    std::function<double(const Vec3d&)> wall;
    std::vector<Vec3> places;
    std::function<bool(const Vec3&)> deep;
};

/// Number of rays that leave the liquid in a vessel unseen.
inline int holes(const Vessel& vessel, int rays) {
    set_walls(vessel.wall);
    const int found = holes(vessel.places, rays, vessel.deep);
    set_walls({});
    return found;
}

/// In a corner of a box the coats of three walls and the free surface close the liquid; the surface is oblique to all
/// of them, and its three feet run out in tips between two walls.
inline Vessel corner() {
    constexpr double d = kSpacing;
    return {[](const Vec3d& x) {
                return std::min({x.x(), x.y(), x.z()});
            },
            stacked(12, 12, 12, 0.1, [](const Vec3d& x) { return x.sum() < 12 * d; }),
            [](const Vec3& x) { return (x - Vec3::Constant(Real(2 * d))).norm() < 1.7 * d; }};
}

/// The surface is level and meets two walls at once in four corners.
inline Vessel tank() {
    constexpr double d = kSpacing;
    return {[](const Vec3d& x) {
                return std::min({x.x(), 10 * d - x.x(), x.y(), 10 * d - x.y(), x.z()});
            },
            stacked(10, 10, 6, 0.1, [](const Vec3d&) { return true; }),
            [](const Vec3& x) { return x.z() < 3 * d && std::hypot(x.x() - 5 * d, x.y() - 5 * d) < 3 * d; }};
}

/// Rings of particles in a cup, half a spacing off its wall: creases run around without a corner.
inline Vessel cup() {
    constexpr double d = kSpacing;
    std::vector<Vec3> places;
    for (int layer = 0; layer < 6; ++layer)
        for (int ring = 0; ring < 6; ++ring) {
            const int count = static_cast<int>(2 * kPi * (ring + 0.5) + 0.5);
            for (int k = 0; k < count; ++k) {
                const double angle = 2 * kPi * (k + 0.5 * (layer % 2)) / count;
                const Vec3d place((ring + 0.5) * std::cos(angle), (ring + 0.5) * std::sin(angle), layer + 0.5);
                places.push_back((d * place).cast<Real>());
            }
        }
    return {[](const Vec3d& x) { return std::min(6 * d - std::hypot(x.x(), x.y()), x.z()); }, std::move(places),
            [](const Vec3& x) { return std::abs(x.z() - 3 * d) < d && std::hypot(x.x(), x.y()) < 3.5 * d; }};
}

}  // namespace thixo::fixture
