#include "pipeline/geometry/match_moments.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

/// Cells of a plate of n layers about a place, 12 by 10 cells wide.
std::vector<Vec3> plate(int layers, const Vec3& at) {
    std::vector<Vec3> cells;
    for (int k = 0; k < layers; ++k)
        for (int j = 0; j < 10; ++j)
            for (int i = 0; i < 12; ++i)
                cells.push_back(at + Vec3(Real(i) - Real(5.5), Real(j) - Real(4.5), Real(k) - Real(layers - 1) / 2));
    return cells;
}

ShapeMoments moments_of(const std::vector<Vec3>& places, const std::vector<Real>& volume) {
    ShapeMoments sum;
    for (std::size_t k = 0; k < places.size(); ++k) {
        const Vec3d x = places[k].cast<double>();
        const double v = static_cast<double>(volume[k]);
        sum += {v, v * x, v * x * x.transpose()};
    }
    return sum;
}

TEST(ShapeMoments, OfABoxAreExactAndOfABallOfSecondOrder) {
    const Vec3d at(3, -1, 2);
    const ShapeMoments b = moments_about(at, moments(translated(box({2, 1, 0.4}), at), 0.07));
    EXPECT_NEAR(b.volume, 0.8, 1e-5);
    EXPECT_LT(b.first.norm(), 1e-5);
    EXPECT_LT((b.second - Mat3d(0.8 / 12 * Vec3d(4, 1, 0.16).asDiagonal())).norm(), 1e-5);
    const auto error = [](double cell) {
        return (moments(sphere(1), cell).second / (4 * kPi / 15) - Mat3d::Identity()).norm();
    };
    EXPECT_LT(error(0.05), 0.01);
    EXPECT_LT(error(0.025), error(0.05) / 3);
}

TEST(MatchedMoments, OfAPlateAreThoseOfItsShape) {
    const Vec3 at(20, 10, -5);
    for (const int layers : {3, 4, 6}) {
        const std::vector<Vec3> cells = plate(layers, at);
        std::vector<Real> volume(cells.size(), 2);  // their sum is twice the shape's
        const ShapeMoments shape = moments(translated(box({12, 10, double(layers)}), at.cast<double>()), 0.25);
        EXPECT_EQ(match_moments(cells, {}, shape, volume), 1);
        const ShapeMoments met = moments_about(at.cast<double>(), moments_of(cells, volume)),
                           right = moments_about(at.cast<double>(), shape);
        EXPECT_NEAR(met.volume / right.volume, 1, 1e-6);
        EXPECT_LT(met.first.norm(), 1e-4 * right.volume);
        EXPECT_NEAR(met.second(2, 2) / right.second(2, 2), 1, 1e-5) << layers;
        EXPECT_NEAR(met.second(0, 0) / right.second(0, 0), 1, 1e-5) << layers;
        // Equal volumes would have all but 1/n^2 of it.
        EXPECT_GT(*std::ranges::max_element(volume), 1 + 0.5 / square(layers));
    }
}

TEST(MatchedMoments, OfASingleLayerStayAcrossIt) {
    const std::vector<Vec3> cells = plate(1, {0, 0, 0});
    std::vector<Real> volume(cells.size(), 1);
    EXPECT_EQ(match_moments(cells, {}, moments(box({12, 10, 1}), 0.25), volume), 1);
    for (const Real v : volume) EXPECT_NEAR(v, 1, 0.05);
}

TEST(MatchedMoments, ChangeNoVolumeByMoreThanThreeQuarters) {
    const std::vector<Vec3> cells = plate(3, {0, 0, 0});
    std::vector<Real> volume(cells.size(), 1);
    const double part = match_moments(cells, {}, moments(box({12, 10, 6}), 0.25), volume);
    EXPECT_LT(part, 1);
    EXPECT_NEAR(moments_of(cells, volume).volume, 12 * 10 * 6, 1e-3 * 12 * 10 * 6);
    for (const Real v : volume) EXPECT_NEAR(v / 2, 1, 0.7501);
}

}  // namespace
}  // namespace thixo
