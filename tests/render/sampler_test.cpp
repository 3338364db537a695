#include "render/sampler.h"

#include <gtest/gtest.h>

#include <set>

#include "render/pixel_filter.h"

namespace thixo::render {
namespace {

TEST(Sampler, EveryPairOfDimensionsIsStratified) {
    // A (0,2)-sequence: the first 16 points have one point in each of 16 boxes of any shape 2^-a x 2^-(4-a), in every
    // pair and pixel.
    for (std::uint32_t pixel = 0; pixel < 20; ++pixel)
        for (int pair = 0; pair < 6; ++pair)
            for (int a = 0; a <= 4; ++a) {
                std::set<int> boxes;
                for (std::uint32_t i = 0; i < 16; ++i) {
                    Sampler sampler(3, pixel, 7 * pixel, i);
                    Vec2f u{0, 0};
                    for (int k = 0; k <= pair; ++k) u = sampler.next2();
                    boxes.insert(int(u.x() * float(1 << a)) * 16 + int(u.y() * float(1 << (4 - a))));
                }
                EXPECT_EQ(boxes.size(), 16u) << pixel << " " << pair << " " << a;
            }
}

TEST(Sampler, PairsAndPixelsAreUncorrelated) {
    // Correlation of 4096 even numbers: standard deviation 1/64; four of them.
    double between_pairs = 0, between_pixels = 0;
    constexpr int n = 4096;
    for (std::uint32_t i = 0; i < n; ++i) {
        Sampler a(1, i % 64, i / 64, 5), b(1, i % 64 + 1, i / 64, 5);
        const Vec2f u = a.next2(), v = a.next2(), w = b.next2();
        between_pairs += 12 * double((u.x() - 0.5f) * (v.x() - 0.5f)) / n;
        between_pixels += 12 * double((u.x() - 0.5f) * (w.x() - 0.5f)) / n;
    }
    EXPECT_LT(std::abs(between_pairs), 4.0 / 64);
    EXPECT_LT(std::abs(between_pixels), 4.0 / 64);
}

TEST(PixelFilter, IsEvenAndStaysWithinItsRadius) {
    const PixelFilter filter;
    double mean = 0, spread = 0;
    constexpr int n = 10000;
    for (int i = 0; i < n; ++i) {
        const float x = filter.offset({(float(i) + 0.5f) / n, 0.5f}).x();
        EXPECT_LE(std::abs(x), PixelFilter::kRadius);
        mean += double(x) / n;
        spread += double(x * x) / n;
    }
    EXPECT_NEAR(mean, 0, 1e-4);
    // Variance of the window on [-1.5, 1.5], by its cosine series: L^2 (1/12 + sum a_k (-1)^k... / (2 pi^2 k^2)) with L
    // = 3.
    const double l2 = 9, a0 = 0.35875;
    const double variance =
        l2 * (1.0 / 12 - (0.48829 - 0.14128 / 4 + 0.01168 / 9) / (2 * kPi * kPi * a0) + 2 * 0.0 / a0);
    EXPECT_NEAR(spread, variance, 0.01);
}

}  // namespace
}  // namespace thixo::render
