// Paint on a body stays on its matter while the surface is resampled. Source: dissertation 6.6.4.
#include "sim/surface/zombies.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/sim/surface/liquid_fixture.h"

namespace thixo {
namespace {

using namespace fixture;
constexpr double d = kSpacing, kRadius = 6 * d;

/// A known flow that keeps volumes. By time t = 1 matter from m is turned about the z axis by 12 rad per metre of
/// height, so by up to 0.7 rad. It is also squashed along the axis to two thirds.
Vec3 carried(const Vec3& m, double t) {
    const double angle = 12 * t * static_cast<double>(m.z()), flat = std::pow(1.5, t), wide = std::sqrt(flat);
    const double c = wide * std::cos(angle), s = wide * std::sin(angle);
    const Vec3d x = m.cast<double>();
    return Vec3d(c * x.x() - s * x.y(), s * x.x() + c * x.y(), x.z() / flat).cast<Real>();
}
Vec3 carried_back(const Vec3& x, double t) {
    const double flat = std::pow(1.5, t), wide = std::sqrt(flat);
    const double z = static_cast<double>(x.z()) * flat, angle = -12 * t * z;
    const Vec3d y = x.cast<double>() / wide;
    return Vec3d(std::cos(angle) * y.x() - std::sin(angle) * y.y(), std::sin(angle) * y.x() + std::cos(angle) * y.y(),
                 z)
        .cast<Real>();
}

/// The surface of a ball after the flow. Its paint was the place of each surfel.
struct Painted {
    SurfaceState surface;
    Zombies zombies;
    Particles particles;
};
Painted flow(bool with_zombies, double melt) {
    set_walls({});
    const std::vector<Vec3> first = packed_ball(kRadius, 0.1);
    Painted p;
    p.particles = liquid(first);
    for (int k = 0; k < 6; ++k) update(p.surface, p.particles);
    p.surface.rest = p.surface.surfels.position;
    p.particles.melt.assign(p.particles.size(), Real(melt));
    if (with_zombies)
        for (std::size_t i = 0; i < p.surface.size(); ++i)
            add_zombie(p.surface.surfels, i, p.surface.rest[i], 0, 0, p.zombies);
    constexpr int kUpdates = 30;
    for (int k = 1; k <= kUpdates; ++k) {
        for (std::size_t j = 0; j < first.size(); ++j)
            p.particles.position[j] = carried(first[j], double(k) / kUpdates);
        update_surface(p.surface, p.particles, {Walls{}, {}, Real(kSpacing), Real(kSupport), {}},
                       with_zombies ? &p.zombies : nullptr);
    }
    return p;
}

/// Distances of the paint from the matter it was painted on, over the ball's diameter, ascending.
std::vector<double> errors(const std::vector<Vec3>& rest, const std::vector<Vec3>& place) {
    std::vector<double> e;
    for (std::size_t i = 0; i < rest.size(); ++i)
        e.push_back(static_cast<double>((rest[i] - carried_back(place[i], 1)).norm()) / (2 * kRadius));
    std::ranges::sort(e);
    return e;
}

TEST(Zombies, KeepWhatIsPaintedOnItsMatter) {
    const Painted p = flow(true, 1);
    const std::vector<double> e = errors(p.surface.rest, p.surface.surfels.position);
    const Painted old = flow(false, 1);
    const std::vector<double> e_old = errors(old.surface.rest, old.surface.surfels.position);
    // The need for melting bodies is a hundredth of the body. Surfels that only copy their paint to new ones, while
    // they are pushed apart, are twice as far off.
    EXPECT_LT(e[e.size() / 2], 0.01);
    EXPECT_LT(e[e.size() * 9 / 10], 0.015);
    EXPECT_GT(e_old[e_old.size() / 2], 1.5 * e[e.size() / 2]);
}

TEST(Zombies, OfSolidMatterChangeNothing) {
    // Its surfels keep every bit of m0, and their places.
    const Painted with = flow(true, 0), without = flow(false, 0);
    EXPECT_EQ(with.surface.rest, without.surface.rest);
    EXPECT_EQ(with.surface.surfels.position, without.surface.surfels.position);
}

TEST(Zombies, LeaveLiquidsThatWereNeverSolidAlone) {
    set_walls({});
    Particles p = liquid(packed_ball(kRadius, 0.1));
    SurfaceState s;
    update(s, p);
    const std::vector<Vec3> before = s.rest;
    Zombies far;
    SurfelCloud one;
    one.position = {Vec3(1, 0, 0)};
    one.normal = {Vec3(0, 0, 1)};
    add_zombie(one, 0, Vec3(1, 0, 0), 0, 0, far);
    take_rest_of_zombies(far, std::vector<std::int32_t>(s.size(), 0), std::vector<Real>(s.size(), 1), Real(kSupport),
                         s);
    EXPECT_EQ(s.rest, before);
}

TEST(Zombies, OfTwoBodiesAreNotMixed) {
    // Two sheets meet in x = 0 and are painted with distant places. Each surfel has the paint of one of them.
    Zombies zombies;
    SurfelCloud cloud;
    SurfaceState s;
    for (int i = -4; i < 4; ++i)
        for (int j = 0; j < 8; ++j) {
            cloud.position.push_back(Vec3(Real((i + 0.5) * d), Real(j * d), 0));
            cloud.normal.push_back(Vec3(0, 0, 1));
            add_zombie(cloud, cloud.position.size() - 1, cloud.position.back() + Vec3(Real(i < 0 ? 0 : 7), 0, 0), 0,
                       i < 0 ? 0 : 1, zombies);
        }
    for (int i = 0; i < 60; ++i) {
        s.surfels.position.push_back(Vec3(Real((i - 30) * 0.1 * d), Real(3.3 * d), 0));
        s.surfels.normal.push_back(Vec3(0, 0, 1));
        s.rest.push_back(Vec3::Zero());
        s.id.push_back(i);
    }
    take_rest_of_zombies(zombies, std::vector<std::int32_t>(s.size(), 0), std::vector<Real>(s.size(), 1),
                         Real(kSupport), s);
    for (std::size_t i = 0; i < s.size(); ++i) {
        const Vec3 off = s.rest[i] - s.surfels.position[i];
        // The paint is linear, and the fit is exact for it, except for the term that keeps it constant across the
        // sheet.
        EXPECT_LT(std::min(off.norm(), (off - Vec3(7, 0, 0)).norm()), 0.05 * d) << i;
    }
}

}  // namespace
}  // namespace thixo
