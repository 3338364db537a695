// Walls do not leak: the pouring test with 50 000 particles.
#include <gtest/gtest.h>

#include "tests/physics/pouring.h"

namespace thixo {
namespace {

TEST(Pouring, NothingLeaksOfFiftyThousandParticles) { fixture::expect_no_leak(0.00257, 45000); }

}  // namespace
}  // namespace thixo
