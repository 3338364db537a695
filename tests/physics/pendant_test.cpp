// Surface tension by the shape of a hanging drop. No factor of the method was set by it.
#include <gtest/gtest.h>

#include "tests/physics/gate.h"
#include "tests/physics/pendant_drop.h"

namespace thixo {
namespace {

TEST(PendantDrop, FitFindsTheDropThatItIsGiven) {
    const pendant::Drop drop{-0.2, 0.09, 0.15};
    std::vector<double> heights;
    for (double z = -0.2; z < -0.03; z += 0.002) heights.push_back(z);
    const pendant::Drop found = pendant::fit(pendant::volumes(drop, heights), {-0.19, 0.1, 0.2});
    EXPECT_NEAR(found.bottom, drop.bottom, 1e-5);
    EXPECT_NEAR(found.radius, drop.radius, 1e-4);
    EXPECT_NEAR(found.capillary_length, drop.capillary_length, 1e-3);
}

void hang(const std::string& law, const std::vector<std::string>& set) {
    const pendant::Hanging found = pendant::hang(set);
    gate::report(law, "largest misfit of the shape, of its volume", "1", found.misfit);
    // A tenth, as TensionScale has it for drops of 7 to 11 spacings.
    gate::expect({law, "tension by its shape over the scene's", "1", found.tension, 1, 0.1, "Young & Laplace"});
}

TEST(PendantDrop, HasTheShapeOfItsTension) {
    hang("pendant drop, spacing 12.5 mm", {});
    hang("pendant drop, spacing 10 mm", {"solver.spacing=0.01"});
    hang("pendant drop, spacing 12.5 mm, steps of 0.2 ms", {"solver.time_step.maximum=2e-4"});
}

}  // namespace
}  // namespace thixo
