#include "sim/time_step.h"

#include <gtest/gtest.h>

#include "tests/sim/fixture.h"

namespace thixo {
namespace {

TEST(TimeStep, DividesWhatIsLeftWithoutASliver) {
    EXPECT_DOUBLE_EQ(divide_evenly(1.0, 0.3), 0.25);
    EXPECT_DOUBLE_EQ(divide_evenly(1.0, 2.0), 1.0);
    EXPECT_DOUBLE_EQ(divide_evenly(0.1 + 0.2, 0.1), (0.1 + 0.2) / 3);  // 0.30000000000000004 is three steps, not four
}

TEST(TimeStep, FramesAreReachedExactly) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.frames.fps = 30;
    scene.bodies = {fixture::body("drop", fixture::shape_at({0, 0, 0}, scene::Sphere{0.02}))};
    Simulation s = make_simulation(scene);
    for (int f = 2; f < 6; ++f) {
        advance_frame(s);
        EXPECT_EQ(s.clock.frame, f);
        EXPECT_EQ(s.clock.time, (f - 1) / 30.0);
    }
}

TEST(TimeStep, StiffnessAndViscosityLimitIt) {
    scene::Scene scene = fixture::empty_space();
    scene.bodies = {fixture::body("drop", fixture::shape_at({0, 0, 0}, scene::Sphere{0.03}))};
    scene.materials[0].stiffness = 1e6;
    const auto limits = [&] {
        Simulation s = make_simulation(scene);
        evaluate(s);
        return step_limits(s.particles, s.sweep, s.problem.materials, s.problem.smoothing, scene.solver.time_step, 0);
    };
    EXPECT_STREQ(limits().cause(), "signal");
    EXPECT_NEAR(limits().smallest(), 0.4 * 0.02 / std::sqrt(1000.0), 1e-7);
    scene.materials[0].viscosity = 1000;
    EXPECT_STREQ(limits().cause(), "signal") << "so thick it is solved implicitly, which is stable at any step";
    scene.solver.viscosity = scene::Viscosity::explicit_force;
    EXPECT_STREQ(limits().cause(), "viscosity");
    EXPECT_NEAR(limits().smallest(), 0.02 * 0.02 / 40, 1e-8);  // nu = 1 m^2/s
}

}  // namespace
}  // namespace thixo
