#include "sim/stage/probes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pipeline/contract/atomic_file.h"
#include "tests/pipeline/driver/temporary_folder.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

scene::Probe probe(scene::Measure measure, scene::Quantity quantity = scene::Quantity::one) {
    scene::Probe p;
    p.name = "p";
    p.measure = measure;
    p.quantity = quantity;
    return p;
}

double value(Simulation& s, const scene::Probe& p) {
    s.problem.scene.probes = {p};
    s.probes = make_probes(s.problem.scene, s.particles);
    return measure(s).at(0).value();
}

// A cube of water of 6 cm that falls freely.
Simulation falling_cube() {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -10};
    scene.bodies = {
        fixture::body("cube", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}), {0.5, 0, 0})};
    Simulation s = make_simulation(scene);
    evaluate(s);
    return s;
}

TEST(Probes, TotalsOfAFallingCubeFollowFromItsMassAndSpeed) {
    Simulation s = falling_cube();
    const double mass = value(s, probe(scene::Measure::total));
    EXPECT_NEAR(mass, 1000 * cube(0.06), 0.05 * mass);  // whole particles: one more or fewer in a row of six
    EXPECT_NEAR(value(s, probe(scene::Measure::total, scene::Quantity::volume)), mass / 1000, 1e-6 * mass / 1000);
    advance_frame(s);
    const double t = 1 / 24.0;
    // Free fall is exact for leapfrog; float state over some hundred steps: 1e-4.
    EXPECT_NEAR(value(s, probe(scene::Measure::total, scene::Quantity::velocity_z)), -10 * t * mass, 1e-4 * mass);
    EXPECT_NEAR(value(s, probe(scene::Measure::mean, scene::Quantity::velocity_x)), 0.5, 1e-4);
    EXPECT_NEAR(value(s, probe(scene::Measure::mean, scene::Quantity::x)), 0.5 * t, 1e-4);
}

TEST(Probes, WhatPressesOnWallsIsCountedOnceAWallAndEmptyInTheFirstFrame) {
    // Two regions that share a pool add up to the whole, and a frame's mean forgets the frame before.
    scene::Scene scene = fixture::tank({0.1, 0.1, 0.2}, 0.06, 0.01);
    scene.world.boundaries.push_back(scene.world.boundaries[0]);
    scene.world.boundaries[1].name = "the same again";
    scene::Probe all = probe(scene::Measure::wall_force), left = all, right = all, disc = all;
    all.direction = left.direction = right.direction = {0, 0, -3};
    left.region = fixture::shape_at({-0.5, 0, 0}, scene::BoxShape{{1, 1, 1}, 0});
    right.region = fixture::shape_at({0.5, 0, 0}, scene::BoxShape{{1, 1, 1}, 0});
    disc.measure = scene::Measure::wall_pressure;
    disc.radius = 1;
    scene.probes = {all, left, right, disc};
    Simulation s = make_simulation(scene);
    evaluate(s);
    for (const std::optional<double>& value : measure(s)) EXPECT_FALSE(value);
    for (int frame = 0; frame < 2; ++frame) {
        advance_frame(s);
        const auto values = measure(s);
        EXPECT_GT(*values[0], 0) << frame;
        EXPECT_NEAR(*values[1] + *values[2], *values[0], 1e-9 * *values[0]) << frame;
        EXPECT_NEAR(*values[3] * pressed_area(1, 0.02), *values[0], 1e-6 * *values[0]) << frame;  // support: a float
        for (const std::optional<double>& value : measure(s)) EXPECT_FALSE(value) << frame;       // no time has gone by
    }
}

TEST(Probes, APoolPressesOnAWettedFloorWithItsWeightAlone) {
    // Adhesion draws the pool to the floor, and the pressure there holds it off. Momentum is what tells: the mean force
    // is the weight less what the pool's motion takes up.
    for (const scene::Pressure solver : {scene::Pressure::dfsph, scene::Pressure::eos}) {
        scene::Scene scene = fixture::tank({0.1, 0.1, 0.2}, 0.04, 0.01);
        scene.solver.pressure = solver;
        scene.materials[0].surface_tension = 1;
        scene.materials[0].viscosity = 0.5;
        scene.world.boundaries[0].contact_angle = 30;
        scene::Probe floor = probe(scene::Measure::wall_force);
        floor.direction = {0, 0, -1};
        scene.probes = {floor};
        scene.frames.fps = 10;
        Simulation s = make_simulation(scene);
        evaluate(s);
        const auto rise = [&] { return fixture::momentum(s.particles).z(); };
        double mass = 0;
        for (const Real m : s.particles.mass) mass += static_cast<double>(m);
        for (int frame = 0; frame < 5; ++frame) advance_frame(s), measure(s);
        const double before = rise();
        advance_frame(s);
        const double force = measure(s)[0].value(), law = mass * 9.81 + (rise() - before) * 10;
        EXPECT_NEAR(force / law, 1, 0.02);  // velocities lag half a step of some twenty
    }
}

TEST(Probes, ExtentIsTheFarthestParticleAndItsQuantileLeavesTheRestBelow) {
    Simulation s = falling_cube();
    scene::Probe p = probe(scene::Measure::extent);
    p.direction = {0, 0, 2};
    double highest = -1;
    for (const Vec3& x : s.particles.position) highest = std::max(highest, static_cast<double>(x.z()));
    EXPECT_EQ(value(s, p), highest);
    p.quantile = 0.5;
    EXPECT_NEAR(value(s, p), 0, 0.005);
    p.quantile = 1;
    p.direction = {0, 0, -1};
    p.region = fixture::shape_at({0, 0, 0.05}, scene::BoxShape{{1, 1, 0.1}, 0});  // the upper half
    EXPECT_LE(value(s, p), 1e-6);                                                 // rounding of a layer in the middle
    EXPECT_GT(value(s, p), -0.01);
}

TEST(Probes, AngularMomentumOfASpinningCubeIsThatOfItsParticles) {
    // A free cube at 10 rad/s about z, seen from its middle and from 1 m beside its way.
    scene::Scene scene = fixture::empty_space();
    scene.bodies = {
        fixture::body("cube", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}), {0.5, 0, 0})};
    scene.bodies[0].angular_velocity = {0, 0, 10};
    Simulation s = make_simulation(scene);
    evaluate(s);
    Vec3d centre(0, 0, 0);
    double spin = 0, mass = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        centre += s.particles.mass[i] * s.particles.position[i].cast<double>();
        mass += s.particles.mass[i];
    }
    centre /= mass;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3d x = s.particles.position[i].cast<double>() - centre;
        spin += s.particles.mass[i] * 10 * (square(x.x()) + square(x.y()));
    }
    scene::Probe p = probe(scene::Measure::total, scene::Quantity::angular_z);
    p.position = centre;
    EXPECT_NEAR(value(s, p), spin, 1e-3 * spin);
    p.position.y() += 1;
    EXPECT_NEAR(value(s, p), spin + 0.5 * mass, 1e-3 * mass);
}

TEST(Probes, AFollowedParticleFallsFreely) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -10};
    scene.materials[0].elastic.youngs_modulus = 1e5;
    scene.bodies = {fixture::body("cube", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}))};
    for (const scene::Quantity q : {scene::Quantity::x, scene::Quantity::z}) {
        scene::Probe p = probe(scene::Measure::follow, q);
        p.position = {0.1, 0, 0.1};  // the farthest corner
        scene.probes.push_back(p);
    }
    Simulation s = make_simulation(scene);
    evaluate(s);
    const auto before = measure(s);
    advance_frame(s);
    const auto after = measure(s);
    EXPECT_NEAR(after.at(1).value() - before.at(1).value(), -5 * square(1 / 24.0), 1e-5);
    EXPECT_GT(after.at(0).value(), 0.02);
}

TEST(Probes, AFollowedParticleWithoutMatterHasNoValue) {
    scene::Scene scene = fixture::empty_space();
    scene.probes = {probe(scene::Measure::follow, scene::Quantity::z)};
    Simulation s = make_simulation(scene);
    evaluate(s);
    EXPECT_FALSE(measure(s).at(0).has_value());
}

TEST(Probes, ElasticAndKineticEnergyOfAFreeBodyAreTheirSumAtTheStart) {
    // A cube of rubber that begins to stretch: its motion goes into its strain, and back. Steps are short, because those
    // of leapfrog conserve an energy that differs from this one by the square of the step.
    scene::Scene scene = fixture::empty_space();
    scene.materials[0].elastic.youngs_modulus = 1e5;
    scene.materials[0].elastic.poisson_ratio = 0.3;
    scene.materials[0].viscosity = 0;
    scene.bodies = {fixture::body("cube", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}))};
    scene.bodies[0].velocity_gradient.x = {8, 0, 0};
    scene.frames.fps = 1000;
    scene.solver.time_step.maximum = 1e-5;
    Simulation s = make_simulation(scene);
    evaluate(s);
    const scene::Probe kinetic = probe(scene::Measure::total, scene::Quantity::energy),
                       elastic = probe(scene::Measure::total, scene::Quantity::elastic_energy);
    const double first = value(s, kinetic);
    EXPECT_EQ(value(s, elastic), 0);
    double largest = 0;
    for (int f = 0; f < 10; ++f) {
        advance_frame(s);
        const double stored = value(s, elastic);
        largest = std::max(largest, stored);
        EXPECT_NEAR(stored + value(s, kinetic), first, 0.01 * first) << f;
    }
    EXPECT_GT(largest, 0.3 * first);
}

TEST(Probes, CountBodiesAndFrontsAndTheAreaOfACut) {
    scene::Scene scene = fixture::empty_space();
    scene.materials[0].elastic.youngs_modulus = 1e5;
    scene.frames.fps = 100;
    scene.bodies = {fixture::body("cube", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}))};
    scene.blades = {{.name = "knife",
                     .body = "cube",
                     .edge = {{{0.001, -0.1, 0.05}}, {{0.001, 0.1, 0.05}}},
                     .motion = {{.time = 0}, {.time = 0.1, .position = {0, 0, -0.1}}}}};
    Simulation s = make_simulation(scene);
    evaluate(s);
    const auto count = [&](scene::Measure m) { return value(s, probe(m)); };
    EXPECT_EQ(count(scene::Measure::bodies), 1);
    EXPECT_EQ(count(scene::Measure::crack_area), 0);
    for (int f = 0; f < 5; ++f) advance_frame(s);
    EXPECT_EQ(count(scene::Measure::fronts), 1);
    // The edge is in the middle, to a row.
    EXPECT_NEAR(count(scene::Measure::crack_area), 0.06 * 0.03, 0.06 * s.solids.breaking[0].row);
    for (int f = 0; f < 8; ++f) advance_frame(s);
    EXPECT_EQ(count(scene::Measure::bodies), 2);
    EXPECT_EQ(count(scene::Measure::fronts), 0);
    // Triangles across the rim count by their middles.
    EXPECT_NEAR(count(scene::Measure::crack_area), square(0.06), 0.06 * s.solids.breaking[0].row);
}

TEST(Probes, APointOutsideOfAllMatterHasNoValue) {
    Simulation s = falling_cube();
    scene::Probe p = probe(scene::Measure::point, scene::Quantity::density);
    EXPECT_NEAR(value(s, p), 1000, 20);  // packed: the summation density within 2 %
    p.position = {1, 0, 0};
    s.problem.scene.probes = {p};
    s.probes = make_probes(s.problem.scene, s.particles);
    EXPECT_FALSE(measure(s).at(0).has_value());
}

TEST(Probes, WhatFlowsThroughADiscIsWhatTheEmitterReleases) {
    // rho A v over 12 frames in which a jet crosses the disc, in layers of one spacing: one layer in forty either way.
    scene::Scene scene = fixture::empty_space();
    scene::Emitter e;
    e.name = "spout";
    e.material = "water";
    e.radius = 0.02;
    e.speed = 1;
    scene.emitters = {e};
    scene::Probe p = probe(scene::Measure::flux);
    p.position = {0, 0, -0.03};
    p.direction = {0, 0, -1};
    p.radius = 0.05;
    scene.probes = {p};
    Simulation s = make_simulation(scene);
    evaluate(s);
    measure(s);
    for (int f = 0; f < 2; ++f) {
        advance_frame(s);
        measure(s);
    }
    double sum = 0;
    for (int f = 0; f < 10; ++f) {
        advance_frame(s);
        sum += measure(s).at(0).value() / 10;
    }
    EXPECT_NEAR(sum, 1000 * kPi * square(0.02), 0.05 * 1000 * kPi * square(0.02));
}

TEST(Probes, FluxOfABodyThatCrossesSeveralSpacingsInAStepIsItsMass) {
    // Solids alone move on by time_step.maximum: 25 mm in one of 5 ms, twelve spacings.
    scene::Scene scene = fixture::empty_space();
    scene.materials[0].elastic.youngs_modulus = 1e5;
    scene.solver.spacing = 0.002;
    scene.bodies = {
        fixture::body("cube", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.02, 0.02, 0.02}, 0}), {5, 0, 0})};
    scene::Probe p = probe(scene::Measure::flux);
    p.position = {0.1, 0, 0};
    p.direction = {1, 0, 0};
    p.radius = 0.05;
    scene.probes = {p};
    Simulation s = make_simulation(scene);
    evaluate(s);
    measure(s);
    advance_frame(s);
    EXPECT_NEAR(measure(s).at(0).value() / 24, 0.008, 1e-5);  // kg/s over a frame
}

TEST(Probes, FluxThroughAPeriodicFaceIsCountedOnBothSides) {
    scene::Scene scene = fixture::empty_space();
    scene.solver.expected_speed = 1;
    scene::PeriodicAxis axis;
    axis.axis = scene::Axis::x;
    axis.from = 0;
    axis.to = 0.1;
    scene.world.periodic = {axis};
    scene.bodies = {
        fixture::body("block", fixture::shape_at({0.05, 0, 0}, scene::BoxShape{{0.1, 0.1, 0.1}, 0}), {0.5, 0, 0})};
    scene::Probe p = probe(scene::Measure::flux);
    p.direction = {1, 0, 0};
    p.radius = 0.3;
    for (const double x : {0.0005, 0.05, 0.0995}) {
        p.position = {x, 0, 0};
        scene.probes.push_back(p);
    }
    Simulation s = make_simulation(scene);
    evaluate(s);
    measure(s);
    for (int f = 0; f < 12; ++f) advance_frame(s);
    const auto flux = measure(s);
    for (const auto& through : flux) EXPECT_NEAR(through.value() / flux[1].value(), 1, 0.1);  // a layer in ten
    EXPECT_GT(flux[1].value(), 0);
}

TEST(ProbeFile, ALineThatIsMissingOrCutIsToldWhereARunContinues) {
    const TemporaryFolder folder;
    Simulation s = falling_cube();
    s.problem.scene.probes = {probe(scene::Measure::total)};
    s.probes = make_probes(s.problem.scene, s.particles);
    const int first = s.problem.scene.frames.first;
    begin_probe_file(folder.path, s, first - 1);
    for (s.clock.frame = first; s.clock.frame < first + 4; ++s.clock.frame) append_probes(folder.path, s);
    const std::string whole = read_whole(folder.path / "probes.csv");
    const auto told = [&](const std::string& text) {
        write_whole(folder.path / "probes.csv", text);
        testing::internal::CaptureStderr();
        begin_probe_file(folder.path, s, first + 3);
        return testing::internal::GetCapturedStderr();
    };
    EXPECT_EQ(told(whole), "");
    const std::string third = fmt::format("\n{},", first + 2);
    const std::size_t at = whole.find(third), end = whole.find('\n', at + 1);
    const std::string without = whole.substr(0, at) + whole.substr(end);
    const std::string cut = whole.substr(0, whole.rfind(',', end)) + whole.substr(end);
    for (const std::string& text : {without, cut})
        EXPECT_NE(told(text).find(fmt::format("frame {};", first + 2)), std::string::npos) << text;
}

}  // namespace
}  // namespace thixo
