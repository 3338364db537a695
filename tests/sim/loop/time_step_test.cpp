#include "sim/loop/time_step.h"

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
    scene.solver.pressure = scene::Pressure::dfsph;
    EXPECT_STREQ(limits().cause(), "viscosity");
    EXPECT_NEAR(limits().smallest(), 0.02 * 0.02 / 80, 1e-8);
}

TEST(ExpectedSpeed, IsThatOfTheFastestWallHandleOrEmitter) {
    // A paddle of 0.2 m turns by 90 degrees in 0.1 s. Smooth motions reach at most twice the mean speed.
    scene::Scene scene = fixture::empty_space();
    EXPECT_LT(expected_speed(scene), 0.2);
    scene::Boundary paddle;
    paddle.shape = fixture::shape_at({0.1, 0, 0}, scene::BoxShape{{0.2, 0.02, 0.02}, 0});
    paddle.motion = {{.time = 0}, {.time = 0.1, .rotate = {0, 0, 90}}};
    scene.world.boundaries = {paddle};
    const double tip = 0.2 * kPi / 2 / 0.1;
    EXPECT_GT(expected_speed(scene), tip);
    EXPECT_LT(expected_speed(scene), 2.05 * tip);

    scene = fixture::empty_space();
    scene::Handle hand;
    hand.region = fixture::shape_at({0, 0, 0}, scene::Sphere{0.1});
    hand.motion = {{.time = 0}, {.time = 0.1, .position = {0.3, 0, 0}}};
    scene.handles = {hand};
    EXPECT_NEAR(expected_speed(scene), 6, 1e-9);

    scene = fixture::empty_space();
    scene::Emitter hose;
    hose.material = "water";
    hose.speed = 2;
    hose.motion = hand.motion;
    scene.emitters = {hose};
    EXPECT_NEAR(expected_speed(scene), 8, 1e-9);
}

TEST(ExpectedSpeed, IsThatOfAFallToAPlaneHoweverItIsPlaced) {
    // A ball of 0.1 m whose top is 1.1 m above the floor at -0.5 m.
    const auto above = [](const scene::Shape& floor) {
        scene::Scene scene = fixture::empty_space();
        scene.world.gravity = {0, 0, -10};
        scene.bodies = {{}};
        scene.bodies[0].shape = fixture::shape_at({0, 0, 0.5}, scene::Sphere{0.1});
        scene.world.boundaries = {{}};
        scene.world.boundaries[0].shape = floor;
        return expected_speed(scene);
    };
    const double speed = std::sqrt(2 * 10 * 1.1);
    EXPECT_NEAR(above(fixture::shape_at({0, 0, 0}, scene::Plane{{0, 0, 1}, -0.5})), speed, 1e-6);
    EXPECT_NEAR(above(fixture::shape_at({0, 0, -0.5}, scene::Plane{{0, 0, 1}, 0})), speed, 1e-6);
    scene::Shape turned = fixture::shape_at({0, 0, 0}, scene::Plane{{1, 0, 0}, -0.25});
    turned.rotate = {0, -90, 0};
    turned.scale = 2;
    EXPECT_NEAR(above(turned), speed, 1e-6);
    scene::Shape sunk = fixture::shape_at({0, 0, 0}, scene::Plane{{0, 0, 2}, 0});
    sunk.offset = -0.5;
    EXPECT_NEAR(above(sunk), speed, 1e-6);
}

}  // namespace
}  // namespace thixo
