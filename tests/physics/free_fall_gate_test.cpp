#include <gtest/gtest.h>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

TEST(FreeFall, FollowsNewtonWhateverTheFluidDoes) {
    // Leapfrog is exact under constant acceleration, and forces between particles cancel. Only rounding of float state
    // remains: over about a hundred steps it is 1e-5 of speeds and distances.
    Simulation s = make_simulation(gate::load("free_fall"));
    const gate::Series series = gate::run(s);
    const double t = series.time.back(), g = 9.81;
    const double height = series.last("height") - series.of("height").front();
    gate::expect({"free fall", "height after 0.5 s", "m", height, 0.5 * t - 0.5 * g * t * t, 1e-4, "Newton"});
    gate::expect({"free fall", "velocity after 0.5 s", "m/s", series.last("fall"), 0.5 - g * t, 1e-4, "Newton"});
    gate::expect({"free fall", "velocity across", "m/s", series.last("drift"), 0.3, 1e-4, "Newton"});
    gate::expect({"free fall", "mass", "kg", series.last("mass"), series.of("mass").front(), 0, "conservation"});
}

}  // namespace
}  // namespace thixo
