// Bodies that yield, beside their laws.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/physics/gate.h"

namespace thixo {
namespace {

using Settings = std::vector<std::string>;

Settings joined(Settings a, const Settings& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

double height_after_fall(const Settings& set) {
    Simulation s = make_simulation(gate::load("clay_ball", set));
    const gate::Series series = gate::run(s);
    return series.last("top") + series.last("low");
}

TEST(ClayBall, KeepsTheSameDentInStepsOfAnyLength) {
    // An impact is no slower than ten milliseconds. Steps of 5 ms or less, split by frames or not, must show the same.
    for (const std::string spacing : {"0.01", "0.0125"}) {
        const Settings at{"solver.spacing=" + spacing};
        const double fine = height_after_fall(joined(at, {"solver.time_step.maximum=0.0002"}));
        EXPECT_LT(fine, 0.09);
        const Settings others[] = {{}, {"frames.fps=240", "frames.last=240"}, {"solver.time_step.maximum=0.001"}};
        for (const Settings& set : others) {
            const std::string named = set.empty() ? "steps of 5 ms" : set[0];
            gate::expect({"clay ball, spacing " + spacing + ", " + named, "height over that in steps of 0.2 ms", "1",
                          height_after_fall(joined(at, set)) / fine, 1, 0.01, "one law, whatever the step"});
        }
    }
}

/// The permanent stretch of a bar that was drawn out by `stretch` under tension alone, from the yield surface. Its
/// permanent shape has the elastic strain a along it and -nu a across, and |dev e| = sqrt(2/3) (1 + nu) a = yield.
double permanent_stretch(double stretch, double nu, double yield) {
    const double a = yield / (1 + nu) / std::sqrt(2.0 / 3);
    return stretch / std::sqrt(1 + 2 * a);
}

struct Drawn {
    double held, released, density;  // stretch of the middle [1], [kg/m^3]
};
Drawn drawn(const Settings& set) {
    Simulation s = make_simulation(gate::load("clay_bar", set));
    const gate::Series series = gate::run(s);
    const auto upper = series.of("upper"), lower = series.of("lower");
    const auto stretch = [&](std::size_t k) { return (upper[k] - lower[k]) / (upper[0] - lower[0]); };
    const std::size_t held = (series.time.size() - 1) / 2;  // just before it is let go
    return {stretch(held), stretch(series.time.size() - 1), series.last("density")};
}

TEST(ClayBar, StaysDrawnOutToTheYieldSurface) {
    for (const std::string spacing : {"0.02", "0.0125"})
        for (const std::string maximum : {"0.005", "0.0005"}) {
            const Drawn bar = drawn({"solver.spacing=" + spacing, "solver.time_step.maximum=" + maximum});
            EXPECT_GT(bar.held, 1.15);
            const std::string law = "clay bar, spacing " + spacing + ", steps of " + maximum + " s";
            gate::expect({law, "permanent stretch over the law's", "1",
                          (bar.released - 1) / (permanent_stretch(bar.held, 0.3, 0.02) - 1), 1, 0.03,
                          "St. Venant, von Mises"});
            gate::expect({law, "density at rest", "rho0", bar.density / 1000, 1, 0.01, "flow keeps the volume"});
        }
}

TEST(ClayBar, IsDrawnOutAlikeAtAnyFrameRateAndStep) {
    const double fine = drawn({"solver.time_step.maximum=0.0005"}).released - 1;
    const double long_steps = drawn({}).released - 1,
                 more_frames = drawn({"frames.fps=240", "frames.last=288"}).released - 1;
    const char *quantity = "permanent stretch over that in steps of 0.5 ms", *source = "one law, whatever the step";
    gate::expect({"clay bar, steps of 5 ms", quantity, "1", long_steps / fine, 1, 0.01, source});
    gate::expect({"clay bar, 240 frames a second", quantity, "1", more_frames / fine, 1, 0.01, source});
}

}  // namespace
}  // namespace thixo
