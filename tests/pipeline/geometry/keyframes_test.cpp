#include "pipeline/geometry/keyframes.h"

#include <gtest/gtest.h>

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

std::vector<RigidKey> keys() {
    return {{0.5, {0, 0, 0}, Quatd::Identity()},
            {1.0, {0.2, 0.1, 0}, rotation_from_degrees({30, 20, 80})},
            {1.8, {0.5, 0.1, 0.4}, rotation_from_degrees({-60, 50, 120})},
            {2.0, {0.5, 0.1, 0.4}, rotation_from_degrees({-60, 50, 120})},
            {3.0, {0.1, -0.3, 0.2}, rotation_from_degrees({10, 0, -20})}};
}

class Motion : public testing::TestWithParam<Interpolation> {};
INSTANTIATE_TEST_SUITE_P(Both, Motion, testing::Values(Interpolation::linear, Interpolation::smooth));

TEST_P(Motion, GoesThroughItsKeys) {
    const RigidMotion motion(keys(), GetParam());
    for (const RigidKey& k : keys()) {
        EXPECT_LT((motion.pose(k.time).translation - k.position).norm(), 1e-12);
        EXPECT_LT(motion.pose(k.time).rotation.angularDistance(k.rotation), 1e-7);  // an arc cosine near 1
    }
}

TEST_P(Motion, VelocityIsTheDerivativeOfThePose) {
    // Central differences of width h: truncation ~ h^2 |x'''| ~ 1e-10 * 1e3, rounding 1e-16/h ~ 1e-11.
    const RigidMotion motion(keys(), GetParam());
    const double h = 1e-5;
    const Vec3d body(0.3, -0.2, 0.5);  // a material point
    for (double t = 0.4003; t < 3.2; t += 0.0137) {
        const RigidVelocity v = motion.velocity(t);
        const RigidPose pose = motion.pose(t);
        const Vec3d difference = (motion.pose(t + h).apply(body) - motion.pose(t - h).apply(body)) / (2 * h);
        const Vec3d exact = v.linear + v.angular.cross(pose.apply(body) - pose.translation);
        EXPECT_LT((difference - exact).norm(), 1e-6) << "at " << t;
    }
}

TEST_P(Motion, IsAtRestOutsideItsKeys) {
    const RigidMotion motion(keys(), GetParam());
    for (const double t : {-1.0, 0.4, 3.1, 100.0}) {
        EXPECT_EQ(motion.velocity(t).linear, Vec3d::Zero());
        EXPECT_EQ(motion.velocity(t).angular, Vec3d::Zero());
    }
    EXPECT_EQ(motion.pose(-1).translation, keys().front().position);
    EXPECT_EQ(motion.pose(9).translation, keys().back().position);
}

TEST_P(Motion, HoldsBetweenEqualKeys) {
    const RigidMotion motion(keys(), GetParam());
    for (double t = 1.8; t <= 2.0; t += 0.01) {
        EXPECT_LT((motion.pose(t).translation - keys()[2].position).norm(), 1e-12);
        EXPECT_LT(motion.velocity(t - 1e-9).angular.norm() * (t > 1.8), 1e-6);
    }
}

TEST(SmoothMotion, VelocitiesAreContinuous) {
    const RigidMotion motion(keys());
    for (const RigidKey& k : keys()) {
        const RigidVelocity before = motion.velocity(k.time - 1e-7), after = motion.velocity(k.time + 1e-7);
        EXPECT_LT((before.linear - after.linear).norm(), 1e-5);  // accelerations below 50 times the gap
        EXPECT_LT((before.angular - after.angular).norm(), 1e-4);
    }
}

TEST(SmoothMotion, NeverOvershootsAStraightRowOfKeys) {
    const RigidMotion motion({{0, {0, 0, 0}}, {1, {0, 0, 1}}, {1.2, {0, 0, 1.05}}, {2, {0, 0, 3}}, {3, {0, 0, 3}}});
    double last = -1e-15;
    for (double t = 0; t <= 3; t += 0.001) {
        const double z = motion.pose(t).translation.z();
        EXPECT_GE(z, last - 1e-12);
        last = z;
    }
    EXPECT_LE(last, 3 + 1e-12);
}

TEST(SmoothMotion, DoesNotDependOnTheFrame) {
    const Quatd turn = rotation_from_degrees({17, 40, 65});
    auto turned = keys();
    for (RigidKey& k : turned) k.position = turn * k.position, k.rotation = turn * k.rotation;
    const RigidMotion a(keys()), b(turned);
    for (double t = 0.5; t < 3; t += 0.05) {
        EXPECT_LT((turn * a.pose(t).translation - b.pose(t).translation).norm(), 1e-12);
        EXPECT_LT((turn * a.velocity(t).angular - b.velocity(t).angular).norm(), 1e-10);
    }
}

TEST(Keys, AreRefusedWhereTheyMakeNoMotion) {
    EXPECT_THROW(RigidMotion({{1, {0, 0, 0}}, {1, {1, 0, 0}}}), InputError);
    EXPECT_THROW(RigidMotion({{0, {std::numeric_limits<double>::infinity(), 0, 0}}}), InputError);
    EXPECT_THROW(motion_from_degrees({0, 1}, {{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 360}}), InputError);
    EXPECT_EQ(RigidMotion().pose(1).translation, Vec3d::Zero());
    EXPECT_FALSE(RigidMotion({{1, {1, 2, 3}}}).moves());
    EXPECT_EQ(RigidMotion({{1, {1, 2, 3}}}).pose(7).translation, Vec3d(1, 2, 3));
}

}  // namespace
}  // namespace thixo
