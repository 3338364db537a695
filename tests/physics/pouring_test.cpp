// Walls do not leak.
#include "tests/physics/pouring.h"

#include <gtest/gtest.h>

namespace thixo {
namespace {

TEST(Pouring, NothingLeaksOutOfFunnelAndGlass) { fixture::expect_no_leak(0.006, 3000); }

}  // namespace
}  // namespace thixo
