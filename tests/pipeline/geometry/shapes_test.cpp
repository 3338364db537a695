#include "pipeline/geometry/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/gradient_noise.h"
#include "pipeline/geometry/tessellate.h"

namespace thixo {
namespace {

// A tumbler of 12 cm with walls of 5 mm and a rounded inner bottom.
const std::vector<Vec2d> kGlass = {{0, 0},          {0.045, 0},     {0.050, 0.120}, {0.0475, 0.1225}, {0.045, 0.120},
                                   {0.0405, 0.016}, {0.038, 0.011}, {0.034, 0.009}, {0, 0.008}};

const std::vector<SweepPoint> kArm = {
    {{-0.7, -0.4, 0.1}, 0.2}, {{-0.2, 0.4, 0}, 0.15}, {{0.4, 0.2, 0.5}, 0.1}, {{0.6, -0.5, 0.2}, 0.25}};

struct Named {
    const char* name;
    Shape shape;
};

std::vector<Named> primitives() {
    return {{"sphere", sphere(0.7)},
            {"ellipsoid", ellipsoid({0.9, 0.5, 0.3})},
            {"flat ellipsoid", ellipsoid({0.9, 0.9, 0.2})},
            {"box", box({1.2, 0.8, 0.5})},
            {"rounded box", box({1.2, 0.8, 0.5}, 0.1)},
            {"cylinder", cylinder(0.5, 1.1)},
            {"rounded cylinder", cylinder(0.5, 1.1, 0.15)},
            {"rounded cone", rounded_cone(0.5, 0.2, 0.8)},
            {"swallowed cone", rounded_cone(0.6, 0.1, 0.3)},
            {"capsule", capsule({-0.3, 0.1, -0.2}, {0.4, 0.2, 0.5}, 0.3)},
            {"torus", torus(0.6, 0.25)},
            {"glass", scaled(revolve(kGlass), 8)},
            {"ring", revolve({{0.5, -0.2}, {0.8, -0.2}, {0.8, 0.3}, {0.5, 0.1}})}};
}

std::vector<Named> combinations() {
    const Shape a = box({1, 0.8, 0.6}), b = translated(sphere(0.5), {0.4, 0.2, 0.2});
    return {{"union", union_of({a, b})},
            {"smooth union", union_of({a, b, translated(b, {-0.9, 0, 0})}, 0.2)},
            {"intersection", intersection_of({a, b})},
            {"smooth intersection", intersection_of({a, b}, 0.1)},
            {"difference", difference_of({a, b})},
            {"smooth difference", difference_of({a, b}, 0.15)},
            {"half ball", intersection_of({b, plane({0, 0, 1}, 0.3)})},
            {"shell", shell(a, 0.1)},
            {"grown", offset(difference_of({a, b}), 0.07)},
            {"shrunk", offset(a, -0.1)},
            {"placed", transformed(difference_of({a, b}), 0.7, rotation_from_degrees({20, 30, 40}), {0.1, 0.2, 0.1})},
            {"tree", union_of({difference_of({a, b}), shell(b, 0.05)}, 0.1)},
            {"sweep", swept(kArm)},
            {"closed sweep", swept(kArm, true)},
            {"mirror", mirrored(b, {1, 0.5, 0}, 0.1)},
            {"smooth mirror", mirrored(b, {1, 0.5, 0}, 0.1, 0.2)},
            {"ring of copies", repeated(translated(box({0.2, 0.1, 0.3}), {0.6, 0, 0}), 7, {0, 0, 0}, 360.0 / 7)},
            {"screw of copies", repeated(translated(sphere(0.2), {0.3, 0, -0.6}), 9, {0, 0, 0.12}, 50, 0.1)},
            {"twist", twisted(a, 150)},
            {"twist aside", twisted(b, -60)},
            {"bend", bent(box({0.4, 0.5, 1.6}), 90)},
            {"bend back", bent(translated(capsule({0, 0, 0}, {0, 0, 1}, 0.15), {0.1, 0, -0.4}), -170)},
            {"noise", roughened(sphere(0.6), 0.05, 0.3, 4)},
            {"noise on a box", roughened(a, 0.04, 0.2, 2)}};
}

Vec3 random_point(std::uint64_t k, double extent = 1.6) {
    const auto u = [&](int axis) { return (random_unit(7, k, 0, axis) - 0.5) * 2 * extent; };
    return Vec3d(u(0), u(1), u(2)).cast<Real>();
}

TEST(Primitives, DistanceIsThatToTheirOwnMesh) {
    // The mesh is made by other code. Chords of 512 steps sag by (1 - cos(pi/512)) r < 2e-5 r; its float vertices add
    // 1e-7.
    for (const Named& p : primitives()) {
        const MeshQuery mesh(tessellate(p.shape, 0.01, 512));
        for (int k = 0; k < 3000; ++k) {
            const Vec3 x = random_point(k);
            ASSERT_NEAR(p.shape.distance(x), mesh.signed_distance(x), 4e-5) << p.name << " at " << x.transpose();
        }
    }
}

TEST(Primitives, LineAlongTheGradientMeetsTheSurface) {
    // x - d grad d is the closest point, where d is differentiable; the steps of the gradient limit the residual to
    // second order.
    int missed = 0;
    for (const Named& p : primitives())
        for (int k = 0; k < 500; ++k) {
            const Vec3 x = random_point(k);
            const Real d = p.shape.distance(x);
            if (std::abs(p.shape.distance(x - d * p.shape.gradient(x, Real(1e-4)))) > 2e-3) ++missed;
        }
    EXPECT_LT(missed, 130);  // 2 % may lie within a step of the medial axis or an edge's fan
}

TEST(Shapes, DistanceNeverChangesFasterThanThePoint) {
    // Together with the right sign this makes |distance| a lower bound. 1e-6: rounding of float distances near 1.
    auto all = primitives();
    for (const Named& c : combinations()) all.push_back(c);
    for (const Named& s : all)
        for (int k = 0; k < 4000; ++k) {
            const Vec3 x = random_point(k),
                       y = x + Vec3(random_point(k + 100000, std::pow(10.0, -3 * random_unit(1, k, 0, 9))));
            ASSERT_LE(std::abs(s.shape.distance(x) - s.shape.distance(y)), (x - y).norm() + 1e-6)
                << s.name << " at " << x.transpose();
        }
}

TEST(Shapes, BoundsHoldTheInsideAndLimitTheDistance) {
    auto all = primitives();
    for (const Named& c : combinations()) all.push_back(c);
    for (const Named& s : all) {
        const Box3 b = s.shape.bounds().value();
        for (int k = 0; k < 4000; ++k) {
            const Vec3 x = random_point(k);
            const Real outside = (b.lower - x).cwiseMax(x - b.upper).cwiseMax(Real(0)).norm();
            ASSERT_GE(s.shape.distance(x), outside > 0 ? outside - Real(1e-6) : std::numeric_limits<Real>::lowest())
                << s.name;
        }
    }
}

TEST(Combinations, SignIsTheBooleanOfTheSigns) {
    const Shape a = box({1, 0.8, 0.6}), b = translated(sphere(0.5), {0.4, 0.2, 0.2});
    for (int k = 0; k < 5000; ++k) {
        const Vec3 x = random_point(k, 0.8);
        const bool in_a = a.distance(x) < 0, in_b = b.distance(x) < 0;
        EXPECT_EQ(union_of({a, b}).distance(x) < 0, in_a || in_b);
        EXPECT_EQ(intersection_of({a, b}).distance(x) < 0, in_a && in_b);
        EXPECT_EQ(difference_of({a, b}).distance(x) < 0, in_a && !in_b);
        EXPECT_EQ(inverted(a).distance(x) < 0, !in_a);
        EXPECT_EQ(shell(a, 0.1).distance(x) < 0, in_a && a.distance(x) > Real(-0.1));
    }
}

TEST(Combinations, BlendingOnlyAddsAndOnlyNearBothSurfaces) {
    const Shape a = box({1, 0.8, 0.6}), b = translated(sphere(0.5), {0.4, 0.2, 0.2});
    const double radius = 0.2;
    const Shape sharp = union_of({a, b}), soft = union_of({a, b}, radius);
    for (int k = 0; k < 5000; ++k) {
        const Vec3 x = random_point(k);
        const double added = sharp.distance(x) - soft.distance(x);
        EXPECT_GE(added, -1e-6);
        EXPECT_LE(added, radius / 4 + 1e-6);
        if (std::abs(a.distance(x) - b.distance(x)) > radius) {
            EXPECT_NEAR(added, 0, 1e-6);
        }
    }
}

TEST(Changes, MovedShapeIsTheShapeSeenFromTheMovedPoint) {
    const Quatd turn = rotation_from_degrees({10, -50, 120});
    const Shape moved = transformed(box({1, 0.8, 0.6}), 1.7, turn, {0.3, -0.2, 0.5});
    for (int k = 0; k < 1000; ++k) {
        const Vec3 x = random_point(k, 0.6);
        const Vec3 image = (turn * (1.7 * x.cast<double>()) + Vec3d(0.3, -0.2, 0.5)).cast<Real>();
        EXPECT_NEAR(moved.distance(image), 1.7 * box({1, 0.8, 0.6}).distance(x), 2e-6);
    }
}

TEST(Changes, DegreesTurnAboutXThenYThenZ) {
    // 90 degrees about x take y to z, 90 degrees about y take z to x, and 90 degrees about z take x to y. So y stays.
    EXPECT_LT((rotation_from_degrees({90, 90, 90}) * Vec3d::UnitY() - Vec3d::UnitY()).norm(), 1e-12);
    EXPECT_LT((rotation_from_degrees({90, 0, 90}) * Vec3d::UnitY() - Vec3d::UnitZ()).norm(), 1e-12);
}

TEST(Changes, WarpedShapesAreTheirOriginalsWhereThePointCameFrom) {
    const Shape a = box({0.5, 0.6, 0.8});
    const Shape twist = twisted(a, 100), bend = bent(a, 120);
    const double R = 0.8 / (120 * kPi / 180);
    for (int k = 0; k < 5000; ++k) {
        const Vec3 x = random_point(k, 0.45);
        const double turn = 100 * kPi / 180 * x.z();
        const Vec3d turned = Eigen::AngleAxisd(turn, Vec3d::UnitZ()) * x.cast<double>();
        const double phi = (x.z() + 0.4) / R;
        const Vec3d arc(R - (R - x.x()) * std::cos(phi), x.y(), -0.4 + (R - x.x()) * std::sin(phi));
        if (std::abs(a.distance(x)) < 1e-5) continue;
        ASSERT_EQ(twist.distance(turned.cast<Real>()) < 0, a.distance(x) < 0);
        if (std::abs(x.z()) < Real(0.4)) {
            ASSERT_EQ(bend.distance(arc.cast<Real>()) < 0, a.distance(x) < 0) << x.transpose();
        }
    }
    EXPECT_THROW(twisted(plane({0, 0, 1}, 0), 10), InputError);
    EXPECT_THROW(bent(box({1, 1, 1}), 150), InputError);  // radius 0.38, half the width 0.5
    EXPECT_THROW(bent(box({1, 1, 10}), 190), InputError);
}

TEST(Changes, CopiesAreTheShapeWhereTheyStand) {
    const Shape a = translated(box({0.3, 0.2, 0.2}), {0.5, 0, -0.3});
    const Shape row = repeated(a, 5, {0, 0.1, 0.15}, 30), image = mirrored(a, {1, 1, 0}, 0.1);
    for (int k = 0; k < 3000; ++k) {
        const Vec3 x = random_point(k, 0.9);
        double nearest = 1e9;
        for (int copy = 0; copy < 5; ++copy) {
            const Vec3d back =
                Eigen::AngleAxisd(-copy * kPi / 6, Vec3d::UnitZ()) * (x.cast<double>() - copy * Vec3d(0, 0.1, 0.15));
            nearest = std::min(nearest, double(a.distance(back.cast<Real>())));
        }
        ASSERT_NEAR(row.distance(x), nearest, 2e-6);
        const Vec3d n = Vec3d(1, 1, 0).normalized(), y = x.cast<double>();
        const Vec3d reflected = y - 2 * (n.dot(y) - 0.1) * n;
        ASSERT_NEAR(image.distance(x), std::min(a.distance(x), a.distance(reflected.cast<Real>())), 2e-6);
    }
    EXPECT_THROW(repeated(a, 0, {1, 0, 0}, 0), InputError);
    EXPECT_THROW(mirrored(a, {0, 0, 0}, 0), InputError);
}

TEST(Changes, NoiseRaisesTheSurfaceByItsHeight) {
    // On a plane the height is the noise itself.
    const Shape ground = roughened(plane({0, 0, 1}, 0), 0.05, 0.3, 3);
    for (int k = 0; k < 3000; ++k) {
        const Vec3 x = random_point(k, 0.9);
        const double height = 0.05 * double(fractal_noise((x / Real(0.3)).cast<float>(), 3).value);
        ASSERT_EQ(ground.distance(x) < 0, double(x.z()) < height);
    }
    EXPECT_THROW(roughened(sphere(1), 0.1, 0, 4), InputError);
    EXPECT_THROW(roughened(sphere(1), 0.1, 1, 0), InputError);
}

TEST(Sweep, IsTheUnionOfItsBalls) {
    // The curve of two points is straight with a linear radius: the union of balls is a rounded cone.
    const Shape cone = swept({{{0, 0, 0}, 0.3}, {{0, 0, 1}, 0.1}});
    for (int k = 0; k < 3000; ++k) {
        const Vec3 x = random_point(k);
        ASSERT_NEAR(cone.distance(x), rounded_cone(0.3, 0.1, 1).distance(x), 1e-4);
    }
    // It runs through its points, with their radii.
    const Shape arm = swept(kArm);
    for (const SweepPoint& p : kArm) EXPECT_LE(arm.distance(p.at.cast<Real>()), -p.radius + 1e-6);
    // A ring of many points is nearly a torus.
    std::vector<SweepPoint> ring;
    for (int k = 0; k < 24; ++k) ring.push_back({0.6 * Vec3d(std::cos(kPi * k / 12), std::sin(kPi * k / 12), 0), 0.2});
    for (int k = 0; k < 3000; ++k) {
        const Vec3 x = random_point(k);
        if (x.head<2>().norm() < Real(0.3)) continue;  // there many points of the ring are about as near
        ASSERT_NEAR(swept(ring, true).distance(x), torus(0.6, 0.2).distance(x), 1e-3);
    }
    EXPECT_THROW(swept({{{0, 0, 0}, 0.3}}), InputError);
    EXPECT_THROW(swept({{{0, 0, 0}, 0.3}, {{0, 0, 0}, 0.3}}), InputError);
    EXPECT_THROW(swept({{{0, 0, 0}, 0.3}, {{0, 0, 1}, 0}}), InputError);
}

TEST(Volume, AgreesWithTheFormulas) {
    // Partly filled cells are second order: (cell/size)^2 ~ 1e-3 at 30 cells across.
    EXPECT_NEAR(volume(sphere(0.5), 0.03) / (kPi / 6), 1, 2e-3);
    EXPECT_NEAR(volume(torus(0.6, 0.25), 0.03) / (2 * kPi * kPi * 0.6 * square(0.25)), 1, 3e-3);
    EXPECT_NEAR(volume(box({1, 0.8, 0.6}), 0.04) / 0.48, 1, 2e-3);
    EXPECT_NEAR(volume(shell(sphere(0.5), 0.1), 0.02) / (4 * kPi / 3 * (cube(0.5) - cube(0.4))), 1, 3e-3);
    EXPECT_NEAR(volume(offset(sphere(0.4), 0.1), 0.03) / (kPi / 6), 1, 2e-3);
    EXPECT_THROW(volume(inverted(sphere(1)), 0.1), InputError);
}

TEST(Revolve, GlassHoldsItsWallsAndNotItsRoom) {
    const Shape glass = revolve(kGlass);
    EXPECT_LT(glass.distance(Vec3(0, 0, Real(0.004))), 0);            // bottom, on the axis
    EXPECT_GT(glass.distance(Vec3(0, 0, Real(0.06))), 0);             // room
    EXPECT_LT(glass.distance(Vec3(0, Real(0.0451), Real(0.06))), 0);  // wall
    EXPECT_GT(glass.distance(Vec3(Real(0.06), 0, Real(0.06))), 0);    // outside
    EXPECT_NEAR(glass.distance(Vec3(0, 0, Real(0.05))), 0.0418,
                1e-3);  // nearest: the bottom at z = 0.008, straight down
    EXPECT_NEAR(glass.distance(Vec3(0, 0, Real(-0.01))), 0.01, 1e-8);  // the axis itself is no surface
}

TEST(Revolve, SignIsRightAtTheHeightOfEveryCorner) {
    // A ray through a corner must be counted once, for every corner and both orientations of the profile.
    const std::vector<Vec2d> backwards(kGlass.rbegin(), kGlass.rend());
    for (const auto& profile : {kGlass, backwards})
        for (const Vec2d& p : kGlass) {
            EXPECT_GT(revolve(profile).distance(Vec3(Real(0.2), 0, Real(p.y()))), 0);
            if (p.y() > 0.009 && p.y() < 0.12) {
                EXPECT_GT(revolve(profile).distance(Vec3(Real(1e-4), 0, Real(p.y()))), 0);
            }
        }
}

TEST(Ellipsoid, FromItsAxesTheNearestPointLeavesThem) {
    // From x on the long axis a, the nearest point of the ellipse (a, b) is off the axis while |x| < a - b^2/a. Its
    // distance is then
    //     b sqrt(1 - x^2/(a^2 - b^2))  [m]
    // Beyond that it is the vertex. The third axis is longer than b. The tolerance is rounding of Real.
    const double a = 0.9, b = 0.3;
    const Shape shape = ellipsoid({a, 0.5, b});
    for (const double x : {0.0, 1e-9, 0.1, 0.4, 0.79, 0.8, 0.81, 0.9, 1.5, 100.0}) {
        const double exact = x < a - b * b / a ? -b * std::sqrt(1 - x * x / (a * a - b * b)) : x - a;
        EXPECT_NEAR(double(shape.distance(Vec3(Real(x), 0, 0))), exact, 1e-6 * std::max(x, 0.3)) << x;
        EXPECT_NEAR(double(shape.distance(Vec3(Real(x), Real(1e-7), Real(-1e-7)))), exact, 2e-6 * std::max(x, 0.3))
            << x;
    }
}

TEST(Combinations, LookOnlyAtWhatIsNearEnough) {
    // Far shapes are passed over by their boxes; the value is that of the sum over all.
    const Shape near = sphere(0.3), far = translated(ellipsoid({0.2, 0.1, 0.1}), {1, 0, 0});
    const double blend = 0.2;
    const Shape both = union_of({near, far}, blend), less = difference_of({near, far}, blend);
    const auto mixed = [&](double p, double q) {
        const double overlap = blend - std::abs(p - q);
        return std::min(p, q) - (overlap > 0 ? overlap * overlap / (4 * blend) : 0);
    };
    for (int i = 0; i < 2000; ++i) {
        const Vec3 x(Real(-0.5 + 0.1 * (i % 20)), Real(-0.5 + 0.1 * (i / 20 % 10)), Real(-0.5 + 0.1 * (i / 200)));
        const double p = double(near.distance(x)), q = double(far.distance(x));
        EXPECT_NEAR(double(both.distance(x)), mixed(p, q), 1e-6);
        // Its box holds the difference from below where that is far too low.
        const double outside = (x.cwiseAbs() - Vec3::Constant(Real(0.3))).cwiseMax(Real(0)).cast<double>().norm();
        EXPECT_NEAR(double(less.distance(x)), std::max(-mixed(-p, q), outside > 0 ? outside : -1e9), 1e-6);
    }
}

TEST(Constructors, RefuseWhatIsNoShape) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(sphere(0), InputError);
    EXPECT_THROW(sphere(nan), InputError);
    EXPECT_THROW(ellipsoid({1, -1, 1}), InputError);
    EXPECT_THROW(box({1, 1, 1}, 0.6), InputError);
    EXPECT_THROW(cylinder(1, 1, 0.51), InputError);
    EXPECT_THROW(torus(0.1, 0.2), InputError);
    EXPECT_THROW(plane({0, 0, 0}, 0), InputError);
    EXPECT_THROW(union_of({}), InputError);
    EXPECT_THROW(union_of({sphere(1)}, -1), InputError);
    EXPECT_THROW(scaled(sphere(1), 0), InputError);
    EXPECT_THROW(revolve({{0, 0}, {1, 0}}), InputError);
    EXPECT_THROW(revolve({{0, 0}, {1, 0}, {-1, 1}}), InputError);
    EXPECT_THROW(revolve({{0, 0}, {1, 1}, {1, 0}, {0, 1}}), InputError);  // crosses itself
    EXPECT_THROW(revolve({{0, 0}, {0.5, 0.5}, {1, 1}}), InputError);      // no area
}

}  // namespace
}  // namespace thixo
