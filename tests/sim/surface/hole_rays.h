// Rays from deep inside a liquid, and liquids in vessels to send them through.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "tests/sim/surface/discs.h"
#include "tests/sim/surface/liquid_fixture.h"

namespace thixo::fixture {

/// Sends rays from the particles that `deep` selects. Returns how many leave the liquid without a hit.
inline int holes(const std::vector<Vec3>& places, int rays, const std::function<bool(const Vec3&)>& deep) {
    Particles p = liquid(places);
    SurfaceState s;
    for (int k = 0; k < 3; ++k) update(s, p);
    std::vector<Vec3> from;
    for (const Vec3& x : p.position)
        if (deep(x)) from.push_back(x);
    EXPECT_GT(from.size(), 10u);
    const Discs discs(s.surfels, widest(s.surfels));
    return static_cast<int>(parallel_sum(static_cast<std::size_t>(rays), [&](std::size_t k) {
        const Vec3& x = from[random_bits(7, k, 0, 2) % from.size()];
        return discs.hit(x, random_direction(k), 40 * kSpacing) ? 0.0 : 1.0;
    }));
}

/// Liquid at rest between walls: distance to them, places of its particles, and which of these are deep inside.
struct Vessel {
    std::function<double(const Vec3d&)> wall;
    std::vector<Vec3> places;
    std::function<bool(const Vec3&)> deep;
};

/// The number of rays that leave the liquid in a vessel without a hit.
inline int holes(const Vessel& vessel, int rays) {
    set_walls(vessel.wall);
    const int found = holes(vessel.places, rays, vessel.deep);
    set_walls({});
    return found;
}

/// In a corner of a box the coats of three walls and the free surface close the liquid. The free surface is oblique to
/// all walls, and its three feet end in tips between two walls.
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

/// Rings of particles in a cup, half a spacing off its wall. Creases run around it without a corner.
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
