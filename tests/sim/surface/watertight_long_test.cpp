// Ten million rays through every crease and corner find no hole.
#include <gtest/gtest.h>

#include "tests/sim/surface/hole_rays.h"

namespace thixo {
namespace {

using namespace fixture;
constexpr int kRays = 10'000'000;

TEST(WatertightLong, InACorner) { EXPECT_EQ(holes(corner(), kRays), 0); }
TEST(WatertightLong, InATank) { EXPECT_EQ(holes(tank(), kRays), 0); }
TEST(WatertightLong, InACup) { EXPECT_EQ(holes(cup(), kRays), 0); }

}  // namespace
}  // namespace thixo
