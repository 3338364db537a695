#include "pipeline/base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace thixo {
namespace {

constexpr int kSamples = 1 << 16;

double sample(int i, int axis) {  // the four counters in turn
    const auto n = static_cast<std::uint64_t>(i);
    switch (axis) {
        case 0:
            return random_unit(n, 5, 6, 7);
        case 1:
            return random_unit(1, n, 6, 7);
        case 2:
            return random_unit(1, 5, n, 7);
        default:
            return random_unit(1, 5, 6, n);
    }
}

TEST(Random, IsUniformAlongEachCounter) {
    // Chi-square over 64 bins has mean 63 and deviation sqrt(126) = 11.2; 5 deviations pass a good generator but for
    // one in 10^6.
    for (int axis = 0; axis < 4; ++axis) {
        std::array<int, 64> bins{};
        for (int i = 0; i < kSamples; ++i) {
            const double u = sample(i, axis);
            ASSERT_GE(u, 0.0);
            ASSERT_LT(u, 1.0);
            ++bins[static_cast<std::size_t>(u * 64)];
        }
        double chi2 = 0;
        const double expected = kSamples / 64.0;
        for (int b : bins) chi2 += (b - expected) * (b - expected) / expected;
        EXPECT_LT(std::abs(chi2 - 63), 5 * std::sqrt(126.0)) << "counter " << axis;
    }
}

TEST(Random, NeighbouringCountersAreUncorrelated) {
    // The correlation of n independent pairs has deviation 1/sqrt(n); 5 deviations.
    for (int axis = 0; axis < 4; ++axis) {
        double sum = 0;
        for (int i = 0; i < kSamples; ++i) sum += 12 * (sample(i, axis) - 0.5) * (sample(i + 1, axis) - 0.5);
        EXPECT_LT(std::abs(sum / kSamples), 5 / std::sqrt(double(kSamples))) << "counter " << axis;
    }
}

TEST(Random, OneChangedBitChangesHalfOfTheBits) {
    // Mean over 4 x 64 flips of 64 result bits: deviation 0.5/sqrt(16384) = 0.4 %; 5 deviations are 2 %.
    std::array<std::uint64_t, 4> counters{11, 22, 33, 44};
    const auto bits = [](const std::array<std::uint64_t, 4>& c) { return random_bits(c[0], c[1], c[2], c[3]); };
    const std::uint64_t before = bits(counters);
    int changed = 0;
    for (auto& c : counters)
        for (int bit = 0; bit < 64; ++bit) {
            c ^= std::uint64_t(1) << bit;
            changed += std::popcount(before ^ bits(counters));
            c ^= std::uint64_t(1) << bit;
        }
    EXPECT_NEAR(changed / (4 * 64 * 64.0), 0.5, 0.02);
}

TEST(Random, CountersDoNotStandForEachOther) {
    EXPECT_NE(random_bits(1, 2, 3, 4), random_bits(2, 1, 3, 4));
    EXPECT_NE(random_bits(1, 2, 3, 4), random_bits(1, 3, 2, 4));
    EXPECT_NE(random_bits(1, 2, 3, 4), random_bits(1, 2, 4, 3));
}

TEST(Random, MixIsTheReferenceSplitMix64) {
    // First outputs of the public reference code for state 0 (prng.di.unimi.it/splitmix64.c).
    EXPECT_EQ(mix64(0), 0xe220a8397b1dcdafull);
    EXPECT_EQ(mix64(0x9e3779b97f4a7c15ull), 0x6e789e6aa1b965f4ull);
    EXPECT_EQ(mix64(2 * 0x9e3779b97f4a7c15ull), 0x06c45d188009454full);
}

}  // namespace
}  // namespace thixo
