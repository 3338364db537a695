// Walls hold: the pouring test at 50 000 particles.
#include <gtest/gtest.h>

#include "tests/physics/pouring.h"

namespace thixo {
namespace {

TEST(Pouring, NothingLeaksOfFiftyThousandParticles) {
    const auto o = fixture::pour(fixture::funnel_scene(0.00257, 0.055), 30);
    EXPECT_GT(o.particles, 45000u);
    EXPECT_TRUE(o.finite);
    std::string where;
    for (const auto& [id, place] : o.outside) where += place;
    EXPECT_TRUE(o.outside.empty()) << where;
    // None stuck: what hangs back in the funnel is less than 1 %.
    EXPECT_LT(o.in_funnel, o.particles / 100);
}

}  // namespace
}  // namespace thixo
