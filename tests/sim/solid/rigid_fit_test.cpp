// The fit of rest shapes to deformed bodies, in double state.
#include "sim/solid/rigid_fit.h"

#include <gtest/gtest.h>

#include "tests/sim/solid/blocks.h"

namespace thixo {
namespace {

using fixture::block;
using fixture::forces;
using fixture::kDistance;
using fixture::prepared;
using fixture::rubber;
using fixture::turn;

const Vec3 kShift(1, -2, 3);

/// Moves one element rigidly, from wherever it is.
void move_rigidly(Elements& e, std::size_t i) {
    e.displacement[i] = quad(turn() * (xyz(e.rest[i]) + xyz(e.displacement[i])) + kShift - xyz(e.rest[i]));
}

TEST(RestShapeFit, RecoversARigidMotion) {
    // Sums of m (m + u)^T, u a hundred times the block's width, cancel to 1/400 of their terms. 125 rounding errors of
    // 1e-16 then leave at most 6e-12 of the turn, and less of the places.
    Elements e = prepared(block(5, 5, 5, kDistance, Real(0.2)), rubber());
    for (std::size_t i = 0; i < e.size(); ++i) move_rigidly(e, i);
    std::vector<SolidBody> bodies = fixture::one_body(e);
    fit_rest_shapes(bodies, e);
    EXPECT_LT((bodies[0].turn - turn().cast<double>()).norm(), 1e-11);
    EXPECT_LT((bodies[0].place - kShift.cast<double>()).norm(), 1e-12);
    for (std::size_t i = 0; i < e.size(); ++i) EXPECT_LT(xyz(e.displacement[i]).norm(), 1e-12) << i;
}

TEST(RestShapeFit, FollowsTheBodyAndMovesNothing) {
    Elements e = prepared(block(5, 5, 5, kDistance, Real(0.2)), rubber());
    fixture::shake(e, kDistance, Real(0.05));
    for (std::size_t i = 0; i < e.size(); ++i) {
        e.displacement[i] = quad(turn() * (xyz(e.rest[i]) + xyz(e.displacement[i])) + Vec3(1, -2, 3) - xyz(e.rest[i]));
        e.velocity[i] = quad(Vec3(1, 2, 3));
    }
    std::vector<SolidBody> bodies = fixture::one_body(e);
    const auto place = [&](std::size_t i) {
        return Vec3d(bodies[0].turn * (xyz(e.rest[i]) + xyz(e.displacement[i])).cast<double>() + bodies[0].place);
    };
    std::vector<Vec3d> before;
    for (std::size_t i = 0; i < e.size(); ++i) before.push_back(place(i));
    const auto force = forces(rubber(), e);
    fit_rest_shapes(bodies, e);
    Real far = 0, largest = 0;
    for (const Vec3& f : force) largest = std::max(largest, f.norm());
    for (std::size_t i = 0; i < e.size(); ++i) {
        EXPECT_LT((place(i) - before[i]).norm(), 1e-14 * 10);
        EXPECT_LT((bodies[0].turn * xyz(e.velocity[i]).cast<double>() - Vec3d(1, 2, 3)).norm(), 1e-14 * 10);
        far = std::max(far, xyz(e.displacement[i]).norm());
    }
    EXPECT_LT(far, kDistance / 2);  // what the shaking did, without turn and shift
    EXPECT_LT((bodies[0].turn - turn().cast<double>()).norm(), 0.05);
    // The forces are those of before, in the new frame.
    const auto after = forces(rubber(), e);
    for (std::size_t i = 0; i < e.size(); ++i)
        EXPECT_LT((bodies[0].turn.cast<Real>() * after[i] - force[i]).norm(), 1e-9 * largest);
}

TEST(RestShapeFit, ReflectsNoBody) {
    // Mirror images fit a mirrored block best; the fit must be the best rotation all the same.
    Elements e = prepared(block(4, 3, 5, kDistance, Real(0.2)), rubber());
    fixture::move(e, [](const Vec3& m) { return Vec3(-m.x(), m.y(), m.z()); });
    std::vector<SolidBody> bodies = fixture::one_body(e);
    fit_rest_shapes(bodies, e);
    EXPECT_NEAR(bodies[0].turn.determinant(), 1, 1e-14);
    EXPECT_LT((bodies[0].turn * bodies[0].turn.transpose() - Mat3d::Identity()).norm(), 1e-14);
}

TEST(RestShapeFit, ElementsWithoutAShareHaveNoPartInIt) {
    Elements e = prepared(block(5, 5, 5, kDistance, Real(0.2)), rubber());
    std::vector<Real> share(e.size(), 0);
    for (std::size_t i = 0; i < e.size(); ++i) {
        if (i % 2 == 0) continue;
        share[i] = 1;
        move_rigidly(e, i);
    }
    std::vector<SolidBody> bodies = fixture::one_body(e);
    fit_rest_shapes(bodies, e, &share);
    EXPECT_LT((bodies[0].turn - turn().cast<double>()).norm(), 1e-11);
    for (std::size_t i = 1; i < e.size(); i += 2) EXPECT_LT(xyz(e.displacement[i]).norm(), 1e-12) << i;
}

TEST(RestShapeFit, ABodyWithoutAnyShareKeepsItsPose) {
    Elements e = prepared(block(3, 3, 3, kDistance, Real(0.2)), rubber());
    for (std::size_t i = 0; i < e.size(); ++i) move_rigidly(e, i);
    const std::vector<Quad> before = e.displacement;
    std::vector<SolidBody> bodies = fixture::one_body(e);
    const std::vector<Real> share(e.size(), 0);
    fit_rest_shapes(bodies, e, &share);
    EXPECT_EQ(bodies[0].turn, Mat3d(Mat3d::Identity()));
    EXPECT_EQ(bodies[0].place, Vec3d(0, 0, 0));
    for (std::size_t i = 0; i < e.size(); ++i) EXPECT_EQ(xyz(e.displacement[i]), xyz(before[i])) << i;
}

}  // namespace
}  // namespace thixo
