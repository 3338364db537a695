#include "pipeline/base/math.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace thixo {
namespace {

TEST(Math, OrthonormalBasisIsARightHandedFrame) {
    for (std::uint64_t i = 0; i < 1000; ++i) {
        Vec3d n(random_unit(1, i, 0, 0) - 0.5, random_unit(1, i, 0, 1) - 0.5, random_unit(1, i, 0, 2) - 0.5);
        if (i == 0) n = {0, 0, 1};
        if (i == 1) n = {0, 0, -1};  // where the form without a sign has its pole
        if (i == 2) n = {1e-9, 0, -1};
        n.normalize();
        Vec3d a, b;
        orthonormal_basis(n, a, b);
        Mat3d frame;
        frame << a, b, n;
        // A dozen roundings of numbers up to one.
        EXPECT_LT((frame.transpose() * frame - Mat3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
        EXPECT_NEAR(1.0, frame.determinant(), 1e-14);
    }
}

TEST(Math, Clamp01KeepsTheUnitInterval) {
    EXPECT_EQ(0.0, clamp01(-0.5));
    EXPECT_EQ(1.0, clamp01(1.5));
    EXPECT_EQ(0.25, clamp01(0.25));
}

}  // namespace
}  // namespace thixo
