#include "sim/surface/liquid_shape.h"

#include <gtest/gtest.h>

#include "tests/sim/surface/liquid_fixture.h"

namespace thixo {
namespace {

using namespace fixture;
constexpr double d = kSpacing;
const Walls kNoWalls{};

struct Liquid {
    Particles particles;
    LiquidPoints points;
    LiquidShape shape;
    explicit Liquid(const std::vector<Vec3>& places)
        : particles(liquid(places)),
          points(gather_liquid(particles, kNoWalls, Real(kSupport))),
          shape{points, kNoWalls, Real(kSupport), Real(d), Real(0.5)} {
        set_colours(points, Real(kSupport), Real(d));
    }
};

TEST(LiquidShape, GradientMatchesDifferences) {
    set_walls({});
    const Liquid l(packed_ball(4 * d, 0.1));
    const double step = 1e-6 * d;
    for (double r = 3 * d; r < 5 * d; r += 0.17 * d) {
        const Vec3 x = Real(r) * Vec3(Real(0.48), Real(0.64), Real(0.6));
        const ColourSample at = l.shape.colour(x, 0);
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 e = Real(step) * Vec3::Unit(axis);
            const double slope = (l.shape.colour(x + e, 0).value - l.shape.colour(x - e, 0).value) / (2 * step);
            EXPECT_NEAR(at.gradient[axis], slope,
                        1e-6 / d);  // slopes are of the size 0.6/d, differences good to 1e-9 of it
        }
    }
}

TEST(LiquidShape, ProjectionEndsOnTheIsoSurface) {
    set_walls({});
    const Liquid l(packed_ball(4 * d, 0.1));
    for (double z = -0.95; z < 1; z += 0.1) {
        Vec3 x = Real(4.2 * d) * Vec3(Real(std::sqrt(1 - z * z)), 0, Real(z));
        ASSERT_TRUE(l.shape.project(x, 0, Real(d)));
        EXPECT_NEAR(l.shape.colour(x, 0).value, 0.5, 0.01);
    }
    Vec3 nowhere(1, 0, 0);
    EXPECT_FALSE(l.shape.project(nowhere, 0, Real(d)));
    EXPECT_EQ(nowhere, Vec3(1, 0, 0));
}

// The level sets about one particle are spheres.
TEST(LiquidShape, CurvatureAboutALoneParticleIsThatOfSpheres) {
    set_walls({});
    const Liquid l({Vec3(0, 0, 0)});
    for (const double r : {0.3 * d, 0.6 * d, 1.2 * d}) {
        const Vec3 n(Real(0.6), 0, Real(0.8));
        EXPECT_NEAR(l.shape.curvature(Real(r) * n, n, 0) * r, 1, 1e-9);
    }
}

TEST(LiquidShape, AnotherComponentIsNotSeen) {
    set_walls({});
    const Liquid l(packed_ball(2 * d, 0));
    EXPECT_EQ(l.shape.colour(Vec3(0, 0, 0), 1).value, 0);
    EXPECT_FALSE(l.shape.depth(Vec3(0, 0, 0), 1).defined);
}

TEST(LiquidShape, TheFieldIsEvenAboutAWall) {
    set_walls([](const Vec3d& x) { return x.z(); });
    const Liquid l(
        packed(Vec3d(-4 * d, -4 * d, 0), Vec3d(4 * d, 4 * d, 3 * d), 0.1, [](const Vec3d&) { return true; }));
    for (double x = -5 * d; x < 5 * d; x += 0.31 * d) {
        // To the depth to which mirror images count.
        const Vec3 above(Real(x), Real(0.1 * d), Real(0.2 * d)), below(Real(x), Real(0.1 * d), Real(-0.2 * d));
        EXPECT_NEAR(l.shape.colour(above, 0).value, l.shape.colour(below, 0).value, 1e-9);
    }
}

TEST(LiquidShape, IsWetNoDeeperThanItsDepthInsideAWall) {
    // A wall as thin as a glass beside coarse particles, and dry room behind it.
    set_walls([](const Vec3d& x) { return std::abs(x.z() + 0.35 * d) - 0.35 * d; });
    const Liquid l(
        packed(Vec3d(-4 * d, -4 * d, 0), Vec3d(4 * d, 4 * d, 3 * d), 0.1, [](const Vec3d&) { return true; }));
    EXPECT_GT(l.shape.depth(Vec3(0, 0, Real(-0.1 * d)), 0).depth, 0);
    for (double z = 0.2 * d; z < 2 * d; z += 0.05 * d)
        EXPECT_LT(l.shape.depth(Vec3(0, 0, Real(-z)), 0).depth, 0) << z / d;
    set_walls({});
}

// A jet leaves a pipe. The plane of the pipe's end face extends through the jet, but there is no wall.
TEST(LiquidShape, HasImagesOnlyBehindWallsThatAreThere) {
    set_walls([](const Vec3d& x) {
        const Vec3d out(std::abs(x.x() + 3 * d) - 2 * d, 0, std::abs(x.z() - 4 * d) - 4 * d);  // a slab: x < -d, z > 0
        return out.cwiseMax(0).norm() + std::min(std::max(out.x(), out.z()), 0.0);
    });
    const Liquid l(
        packed(Vec3d(-0.6 * d, -4 * d, -4 * d), Vec3d(3 * d, 4 * d, 4 * d), 0.1, [](const Vec3d&) { return true; }));
    const LiquidPart& part = l.points.part[0];
    int seen = 0;
    for (Index k = 0; k < part.images.size(); ++k) {
        if (part.mirrors[k][1] != kNone) continue;
        const Vec3 middle = (part.images.position[k] + l.particles.position[part.images.particle[k]]) / 2;
        EXPECT_NEAR(wall_distance(kNoWalls, middle), 0, 0.31 * d) << middle.transpose() / d;
        ++seen;
    }
    EXPECT_GT(seen, 50);
    set_walls({});
}

}  // namespace
}  // namespace thixo
