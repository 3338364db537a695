#include "sim/surface/displace.h"

#include <gtest/gtest.h>

#include "tests/sim/surface/liquid_fixture.h"

namespace thixo {
namespace {

using namespace fixture;
constexpr double d = kSpacing;

/// Surfels half a spacing outside a ball of particles, where the neighbourhood is one-sided.
SurfaceState surfels_on_ball(double radius, int n) {
    SurfaceState s;
    for (int i = 0; i < n; ++i) {
        const double z = 1 - (2 * i + 1.0) / n, ring = std::sqrt(1 - z * z), angle = i * kPi * (3 - std::sqrt(5.0));
        const Vec3 normal(Real(ring * std::cos(angle)), Real(ring * std::sin(angle)), Real(z));
        Vec3 a, b;
        orthonormal_basis(normal, a, b);
        s.surfels.position.push_back(Real(radius) * normal);
        s.surfels.normal.push_back(normal);
        s.surfels.axis1.push_back(Real(0.5 * d) * a);
        s.surfels.axis2.push_back(Real(0.5 * d) * b);
        s.id.push_back(i);
        s.body.push_back(0);
        s.rest.push_back(Real(radius) * normal);
        s.velocity.push_back(Vec3(0, 0, 0));
        s.temperature.push_back(0);
    }
    return s;
}

TEST(Displace, IsExactForATranslation) {
    Particles p = liquid(packed_ball(4 * d, 0.1));
    const Vec3 way(Real(0.3 * d), Real(-0.7 * d), Real(0.1 * d));
    for (Vec3& x : p.position) x += way;
    SurfaceState s = surfels_on_ball(3.9 * d, 200);
    const SurfaceState before = s;
    displace(s, p, std::vector<std::int32_t>(s.size(), 0), Real(kSupport), Real(1));
    for (std::size_t i = 0; i < s.size(); ++i) {
        // With double state only rounding remains.
        EXPECT_LT((s.surfels.position[i] - before.surfels.position[i] - way).norm(), 1e-12 * d);
        EXPECT_LT((s.surfels.normal[i] - before.surfels.normal[i]).norm(), 1e-12);
    }
}

TEST(Displace, TurnsSurfelsWithATurningLiquid) {
    Particles p = liquid(packed_ball(4 * d, 0.1));
    const double angle = 0.05;
    const Mat3 turn = Eigen::AngleAxis<Real>(Real(angle), Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (Vec3& x : p.position) x = turn * x;
    SurfaceState s = surfels_on_ball(3.9 * d, 200);
    const SurfaceState before = s;
    displace(s, p, std::vector<std::int32_t>(s.size(), 0), Real(kSupport), Real(1));
    for (std::size_t i = 0; i < s.size(); ++i) {
        const Vec3 expected = turn * before.surfels.position[i];
        // At the surface the particles spread by 0.03 h^2 across it: the term eps = 0.005 h^2 damps the gradient by
        // 0.15. Position: that, times the angle, times the lever from the particles' mean, a spacing; sparse places see
        // twice as much.
        EXPECT_LT((s.surfels.position[i] - expected).norm(), 0.3 * angle * d);
        EXPECT_LT((s.surfels.normal[i] - turn * before.surfels.normal[i]).norm(), 0.3 * angle);
        EXPECT_NEAR(s.surfels.axis1[i].dot(s.surfels.normal[i]), 0, 1e-9 * d);
        EXPECT_NEAR(s.surfels.axis1[i].cross(s.surfels.axis2[i]).normalized().dot(s.surfels.normal[i]), 1, 1e-9);
    }
}

TEST(Displace, StretchesDiscsWithTheirMatter) {
    Particles p = liquid(packed_ball(4 * d, 0.1));
    Mat3 stretch = Mat3::Identity();
    stretch(0, 0) = Real(1.2);
    stretch(0, 1) = Real(0.1);
    for (Vec3& x : p.position) x = stretch * x;
    SurfaceState s = surfels_on_ball(3 * d, 200);  // among the particles, where the sums are full
    const SurfaceState before = s;
    displace(s, p, std::vector<std::int32_t>(s.size(), 0), Real(kSupport), Real(1));
    for (std::size_t i = 0; i < s.size(); ++i) {
        // As above: eps = 0.005 h^2 beside the spread of the particles, here 0.05 to 0.09 h^2 each way, damps a tenth.
        EXPECT_LT((s.surfels.axis1[i] - stretch * before.surfels.axis1[i]).norm(), 0.1 * 0.25 * 0.5 * d);
        EXPECT_LT((s.surfels.axis2[i] - stretch * before.surfels.axis2[i]).norm(), 0.1 * 0.25 * 0.5 * d);
    }
    SurfaceState kept = before;
    displace(kept, p, std::vector<std::int32_t>(s.size(), 0), Real(kSupport), Real(0.5 * d));
    for (const auto* axes : {&kept.surfels.axis1, &kept.surfels.axis2})
        for (const Vec3& t : *axes) EXPECT_LT(t.norm(), 0.5 * d * (1 + 1e-12));
}

TEST(Displace, LeavesSurfelsWithoutParticlesWhereTheyAre) {
    Particles p = liquid({Vec3(1, 1, 1)});
    SurfaceState s = surfels_on_ball(4 * d, 20);
    const SurfaceState before = s;
    displace(s, p, std::vector<std::int32_t>(s.size(), 0), Real(kSupport), Real(1));
    EXPECT_EQ(s.surfels.position, before.surfels.position);
}

TEST(Displace, InterpolatesAttributesAsAMean) {
    Particles p = liquid(packed_ball(4 * d, 0.1));
    p.velocity.assign(p.size(), Vec3(1, 2, 3));
    p.temperature.assign(p.size(), 37);
    p.body.assign(p.size(), 5);
    SurfaceState s = surfels_on_ball(4 * d, 50);
    interpolate_attributes(s, p, std::vector<std::int32_t>(s.size(), 0), Real(kSupport));
    for (std::size_t i = 0; i < s.size(); ++i) {
        EXPECT_LT((s.velocity[i] - Vec3(1, 2, 3)).norm(), 1e-12);
        EXPECT_NEAR(s.temperature[i], 37, 1e-12);
        EXPECT_EQ(s.body[i], 5);
    }
}

}  // namespace
}  // namespace thixo
