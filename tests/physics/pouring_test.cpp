// Walls hold.
#include "tests/physics/pouring.h"

#include <gtest/gtest.h>

namespace thixo {
namespace {

TEST(Pouring, NothingLeaksOutOfFunnelAndGlass) {
    const auto o = fixture::pour(fixture::funnel_scene(0.006, 0.055), 30);
    EXPECT_GT(o.particles, 3000u);
    EXPECT_TRUE(o.finite);
    std::string where;
    for (const auto& [id, place] : o.outside) where += place;
    EXPECT_TRUE(o.outside.empty()) << where;
    // None stuck: what hangs back in the funnel is less than 1 %.
    EXPECT_LT(o.in_funnel, o.particles / 100);
}

}  // namespace
}  // namespace thixo
