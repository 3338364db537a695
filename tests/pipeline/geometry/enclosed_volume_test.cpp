#include "pipeline/geometry/enclosed_volume.h"

#include <gtest/gtest.h>

#include "tests/pipeline/geometry/sampled_surfaces.h"

namespace thixo {
namespace {

constexpr double kSupport = 3;       // in spacings of the samples, as surfels have it
constexpr double kPromised = 0.005;  // the tolerance the method is built for

double volume(const fixture::Samples& s) { return enclosed_volume(s.position, s.normal, Real(kSupport * s.spacing)); }

void append(fixture::Samples& a, const fixture::Samples& b) {
    a.position.insert(a.position.end(), b.position.begin(), b.position.end());
    a.normal.insert(a.normal.end(), b.normal.begin(), b.normal.end());
}

constexpr double kSphere = 4 * kPi / 3;

TEST(EnclosedVolume, OfASphere) {
    for (const int n : {5000, 20000}) EXPECT_NEAR(volume(fixture::sphere(n, 1)), kSphere, kPromised * kSphere);
    // Off the lattice and of another size: the grid must not matter.
    const double ball = kSphere * cube(0.037);
    EXPECT_NEAR(volume(fixture::sphere(5000, 0.037, Vec3(Real(1.2345), Real(-7.1), Real(0.001)))), ball,
                kPromised * ball);
}

TEST(EnclosedVolume, OfATorus) {
    const double torus = 2 * kPi * kPi * 1 * 0.4 * 0.4;
    EXPECT_NEAR(volume(fixture::torus(0.025, 1, 0.4)), torus, kPromised * torus);
}

TEST(EnclosedVolume, LeavesOutACavity) {
    auto shell = fixture::sphere(12000, 1);
    auto hole = fixture::sphere(3000, 0.5);
    for (Vec3& n : hole.normal) n = -n;
    append(shell, hole);
    EXPECT_NEAR(volume(shell), kSphere * (1 - 0.125), kPromised * kSphere);
}

TEST(EnclosedVolume, SumsOverBodiesThatTouch) {
    auto two = fixture::sphere(5000, 1);
    std::vector<std::int32_t> body(two.position.size(), 0);
    append(two, fixture::sphere(5000, 1, Vec3(0, 0, Real(2.01))));
    body.resize(two.position.size(), 7);
    EXPECT_NEAR(enclosed_volume(two.position, two.normal, Real(kSupport * two.spacing), body), 2 * kSphere,
                2 * kPromised * kSphere);
}

// A sheet with its faces so near that each support holds both, in three poses; its rim is round.
TEST(EnclosedVolume, OfAThinSheet) {
    constexpr double spacing = 0.06;
    for (const double thickness : {0.5 * spacing, spacing, 2 * spacing, 3 * spacing})
        for (const double turn : {0.0, 0.5, 1.0}) {
            const Eigen::AngleAxis<Real> pose(Real(turn), Vec3(1, 2, 3).normalized());
            fixture::Samples s;
            s.spacing = spacing;
            const auto add = [&](const Vec3d& p, const Vec3d& n) {
                s.position.push_back(pose * p.cast<Real>());
                s.normal.push_back(pose * n.cast<Real>());
            };
            for (double x = -1; x < 1; x += spacing)
                for (double y = -1; y < 1; y += spacing)
                    for (const double side : {-1.0, 1.0})
                        if (std::hypot(x, y) < 1) add({x, y, side * thickness / 2}, {0, 0, side});
            const int around = static_cast<int>(2 * kPi / spacing);
            const int across = std::max(1, static_cast<int>(kPi / 2 * thickness / spacing));
            for (int k = 0; k < around; ++k)
                for (int i = 0; i < across; ++i) {
                    const double up = kPi * ((i + 0.5) / across - 0.5), angle = 2 * kPi * k / around;
                    const Vec3d n(std::cos(up) * std::cos(angle), std::cos(up) * std::sin(angle), std::sin(up));
                    add(Vec3d(std::cos(angle), std::sin(angle), 0) + thickness / 2 * n, n);
                }
            const double r = thickness / 2, expected = kPi * (thickness + kPi * r * r) + kSphere * cube(r);
            // The rim of the thinnest is a single row of surfels: 5 % are four tenths of a spacing at its edge.
            EXPECT_NEAR(volume(s), expected, 0.05 * expected) << thickness / spacing << " spacings, turned " << turn;
        }
}

TEST(EnclosedVolume, OfSmallDrops) {
    for (const double radius : {1.5, 2.0, 3.0}) {  // in spacings, half a support and more
        const double expected = kSphere;
        EXPECT_NEAR(volume(fixture::sphere(static_cast<int>(4 * kPi * square(radius)), 1)), expected, 0.08 * expected)
            << radius;
    }
}

TEST(EnclosedVolume, OfNothingIsNothing) { EXPECT_EQ(enclosed_volume({}, {}, 1), 0); }

}  // namespace
}  // namespace thixo
