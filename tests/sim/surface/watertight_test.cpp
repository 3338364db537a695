// Surfaces have no holes. A hole is found by a ray from deep inside that leaves without meeting a disc.
#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "tests/sim/surface/hole_rays.h"

namespace thixo {
namespace {

using namespace fixture;
constexpr double d = kSpacing;

constexpr int kRays = 200000;

TEST(Watertight, Ball) {
    set_walls({});
    EXPECT_EQ(holes(packed_ball(6 * d, 0.1), kRays, [](const Vec3& x) { return x.norm() < 4 * d; }), 0);
}

TEST(Watertight, Block) {
    set_walls({});
    const Vec3d size(12 * d, 10 * d, 7 * d);
    const auto places = packed(Vec3d(0, 0, 0), size, 0.1, [](const Vec3d&) { return true; });
    EXPECT_EQ(holes(places, kRays,
                    [&](const Vec3& x) {
                        return (x.array() > Real(2 * d)).all() &&
                               (x.cast<double>().array() < size.array() - 2 * d).all();
                    }),
              0);
}

// A ball with arms, dents, threads and loose particles around it.
TEST(Watertight, SplashyBlob) {
    set_walls({});
    auto places = packed(Vec3d::Constant(-9 * d), Vec3d::Constant(9 * d), 0.2, [](const Vec3d& x) {
        const Vec3d n = x.normalized();
        const double bumps = std::sin(7 * n.x() + 1) * std::sin(6 * n.y()) * std::sin(8 * n.z() + 2);
        return x.norm() < (5.5 + 3 * bumps) * d;
    });
    for (std::uint64_t k = 0; k < 60; ++k) {
        const auto at = [&](int use) { return Real((2 * random_unit(9, k, 0, use) - 1) * 10 * d); };
        places.emplace_back(at(0), at(1), at(2));
    }
    EXPECT_EQ(holes(places, kRays, [](const Vec3& x) { return x.norm() < 1.5 * d; }), 0);
}

TEST(Watertight, InACorner) { EXPECT_EQ(holes(corner(), kRays), 0); }
TEST(Watertight, InATank) { EXPECT_EQ(holes(tank(), kRays), 0); }
TEST(Watertight, InACup) { EXPECT_EQ(holes(cup(), kRays), 0); }

}  // namespace
}  // namespace thixo
