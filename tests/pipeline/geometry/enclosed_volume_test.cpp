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

TEST(EnclosedVolume, OfNothingIsNothing) { EXPECT_EQ(enclosed_volume({}, {}, 1), 0); }

}  // namespace
}  // namespace thixo
