// Contact's broad phase finds every pair that touches, and no other.
#include "sim/contact/broad.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/random.h"

namespace thixo {
namespace {

Box3 random_box(std::uint64_t k, double extent, double size) {
    const auto unit = [&](std::uint64_t use) { return static_cast<Real>(random_unit(11, k, use, 0x626f78)); };
    const Vec3 middle = static_cast<Real>(extent) * Vec3(unit(0), unit(1), unit(2));
    const Vec3 half = static_cast<Real>(size / 2) * Vec3(unit(3), unit(4), unit(5));
    return {middle - half, middle + half};
}

TEST(BroadPhase, FindsThePairsThatATestOfAllFinds) {
    for (const double size : {0.05, 0.3, 1.5}) {
        std::vector<Box3> boxes;
        for (std::uint64_t k = 0; k < 300; ++k) boxes.push_back(random_box(k, 1, size));
        boxes[7] = {Vec3::Constant(1), Vec3::Constant(-1)};  // empty: touches nothing
        std::vector<std::pair<std::int32_t, std::int32_t>> all;
        for (std::int32_t a = 0; a < 300; ++a)
            for (std::int32_t b = a + 1; b < 300; ++b)
                if (a != 7 && b != 7 &&
                    gap_of(boxes[static_cast<std::size_t>(a)], boxes[static_cast<std::size_t>(b)]) <= 0)
                    all.emplace_back(a, b);
        EXPECT_EQ(touching_pairs(boxes), all);
    }
}

TEST(BroadPhase, ListsThePartnersOfEachBoxInOrder) {
    std::vector<Box3> boxes;
    for (std::uint64_t k = 0; k < 200; ++k) boxes.push_back(random_box(k, 1, 0.3));
    const auto pairs = touching_pairs(boxes);
    const Partners partners = touching_partners(boxes);
    ASSERT_EQ(partners.partner.size(), 2 * pairs.size());
    for (std::int32_t k = 0; k < 200; ++k) {
        const auto of = partners.of(static_cast<std::size_t>(k));
        EXPECT_TRUE(std::ranges::is_sorted(of));
        for (const std::int32_t other : of)
            EXPECT_TRUE(std::ranges::binary_search(pairs, std::pair(std::min(k, other), std::max(k, other))));
    }
    EXPECT_TRUE(touching_partners({}).partner.empty());
}

}  // namespace
}  // namespace thixo
