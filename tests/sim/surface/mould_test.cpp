// The external potential draws a surface to a shape.
#include "sim/surface/mould.h"

#include <gtest/gtest.h>

#include "pipeline/geometry/shapes.h"
#include "tests/sim/surface/liquid_fixture.h"

namespace thixo {
namespace {

using namespace fixture;
constexpr double d = kSpacing;

/// The surface of a ball after some updates beside a box whose lower face cuts it at `height`.
SurfaceState beside_face(double height, Real weight, const scene::Surface& params) {
    set_walls({});
    Particles p = liquid(packed_ball(5 * d, 0.1));
    const Shape box = transformed(thixo::box({20 * d, 20 * d, 4 * d}, 0), 1, Quatd::Identity(), {0, 0, height + 2 * d});
    const std::vector<Mould> moulds{{box, weight, Real(0.5 * d)}};
    SurfaceState s;
    for (int k = 0; k < 12; ++k) update_surface(s, p, {Walls{}, params, Real(kSpacing), Real(kSupport), moulds});
    return s;
}

/// The largest distance from the face of the surfels of the ball's top that are within the mould's range.
double off_face(const SurfaceState& s, double height, int& count) {
    double most = 0;
    count = 0;
    for (std::size_t i = 0; i < s.size(); ++i) {
        const Vec3& x = s.surfels.position[i];
        if (std::hypot(x.x(), x.y()) > 1.2 * d || x.z() < 0) continue;
        ++count;
        most = std::max(most, std::abs(double(x.z()) - height));
    }
    return most;
}

// The pull of the others is a ten-thousandth of it: a hundredth of a surfel's own tolerance.
TEST(Mould, DominantIsTakenOnExactly) {
    const double height = 5.1 * d;
    int count = 0;
    EXPECT_LT(off_face(beside_face(height, 10'000, {}), height, count), 1e-3 * d);
    EXPECT_GT(count, 10);
}

// Where weights add up to more than one, each potential has its share. The remaining distance is at most the pull of
// the other potentials, 0.9 together, over half a spacing.
TEST(Mould, HasItsShareBesideTheOtherPotentials) {
    const double height = 5.1 * d;
    int count = 0;
    EXPECT_LT(off_face(beside_face(height, 100, {}), height, count), 0.9 / 100 * 0.5 * d + 1e-3 * d);
    EXPECT_GT(count, 10);
}

TEST(Mould, OutOfReachDoesNothing) {
    const SurfaceState far = beside_face(9 * d, 1, {}), none = beside_face(9 * d, 0, {});
    EXPECT_EQ(far.surfels.position, none.surfels.position);
}

// Liquid fills a shape from inside as it coats it from outside. The pull is the same, and normals keep their side.
TEST(Mould, PullsFromBothSides) {
    const std::vector<Mould> moulds{{sphere(1), 1, Real(0.2)}};
    const Vec3 up(0, 0, 1);
    for (const Real z : {Real(0.9), Real(1.1)})
        for (const Real side : {Real(-1), Real(1)}) {
            const MouldPull pull = pull_of_moulds(moulds, z * up, side * up, Real(1e-3));
            EXPECT_NEAR(pull.force.z(), 1 - z, 1e-5);
            EXPECT_NEAR(pull.outward.z(), side, 1e-5);
        }
    EXPECT_EQ(pull_of_moulds(moulds, Real(1.3) * up, up, Real(1e-3)).weight, 0);
    EXPECT_EQ(pull_of_moulds(moulds, Real(1.1) * up, Vec3(1, 0, 0), Real(1e-3)).weight, 0);
}

}  // namespace
}  // namespace thixo
