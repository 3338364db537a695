#include "sim/sources/emitter.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/geometry/packing.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

scene::Scene jet_scene(double radius, double speed) {
    scene::Scene s = fixture::empty_space();
    scene::Emitter e;
    e.name = "spout";
    e.material = "water";
    e.radius = radius;
    e.speed = speed;
    s.emitters = {e};
    return s;
}

// A jet flies freely for this time. The emitter alone is called every `dt`.
Particles free_jet(const scene::Scene& scene, double seconds, double dt) {
    Simulation s = make_simulation(scene);
    std::int64_t id = 0;
    for (double t = 0; t < seconds; t += dt) {
        emit_particles(sources_of(s), t, dt, s.emitters, s.particles, id);
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            s.particles.position[i] += static_cast<Real>(dt) * s.particles.velocity[i];
    }
    EXPECT_EQ(s.emitters[0].blocked, 0);
    return s.particles;
}

TEST(Emitter, ReleasesDensityTimesAreaTimesSpeed) {
    // Layers are whole: over n layers the rate is exact to one layer in n, under 2 % after 60 layers.
    for (const double radius : {0.011, 0.02, 0.045}) {
        const double speed = 1.3, seconds = 0.6;
        const Particles p = free_jet(jet_scene(radius, speed), seconds, 0.0007);
        double mass = 0;
        for (const Real m : p.mass) mass += static_cast<double>(m);
        const double expected = 1000 * kPi * radius * radius * speed * seconds;
        EXPECT_NEAR(mass, expected, 0.02 * expected) << "radius " << radius;
    }
}

TEST(Emitter, NeverPutsParticlesNearerThanPointSevenSpacings) {
    scene::Scene scene = jet_scene(0.03, 0.8);
    scene.emitters[0].jitter = 0.4;  // enough for two neighbours to meet
    Simulation s = make_simulation(scene);
    std::int64_t id = 0;
    for (double t = 0; t < 0.2; t += 0.0005) {
        emit_particles(sources_of(s), t, 0.0005, s.emitters, s.particles, id);
        for (Vec3& x : s.particles.position) x.z() -= Real(0.0005 * 0.8);
    }
    const auto& x = s.particles.position;
    ASSERT_GT(x.size(), 100u);
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) ASSERT_GT((x[i] - x[j]).norm(), 0.00699);
}

TEST(Emitter, FullPlaceMakesNoParticles) {
    const scene::Scene scene = jet_scene(0.03, 0.8);
    Simulation s = make_simulation(scene);
    std::int64_t id = 0;
    // No particle moves on, so that every site is taken after the first two layers.
    for (double t = 0; t < 0.5; t += 0.01) emit_particles(sources_of(s), t, 0.01, s.emitters, s.particles, id);
    EXPECT_GT(s.emitters[0].blocked, static_cast<std::int64_t>(s.particles.size()));
    EXPECT_EQ(static_cast<std::size_t>(id), s.particles.size());
}

TEST(Emitter, JetHasTheRestDensityInside) {
    // 2 %: layers are spaced for the exact rate, which differs from the packing's spacing by the rounding of sites per
    // layer.
    const scene::Scene scene = jet_scene(0.05, 1);
    Simulation s = make_simulation(scene);
    s.particles = free_jet(scene, 0.15, 0.0005);
    s.problem.scene.emitters.clear();
    evaluate(s);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3& x = s.particles.position[i];
        if (std::hypot(x.x(), x.y()) > 0.028 || x.z() > -0.025 || x.z() < -0.12) continue;
        sum += s.particles.density[i];
        ++count;
    }
    ASSERT_GT(count, 50);
    EXPECT_NEAR(sum / count, 1000, 20);
}

TEST(Emitter, ReleasesItsRate) {
    scene::Scene scene = jet_scene(0.02, 0);
    scene.emitters[0].rate = 2e-3;  // m^3/s: 1.6 m/s through the disc
    const double seconds = 0.5;
    const Particles p = free_jet(scene, seconds, 0.0005);
    const double expected = scene.emitters[0].rate * seconds / cube(0.01);
    EXPECT_NEAR(static_cast<double>(p.size()), expected, 0.02 * expected);  // a layer in 80, twice
    const double speed = 2e-3 / (kPi * square(0.02));
    for (const Vec3& v : p.velocity) EXPECT_NEAR(static_cast<double>(v.norm()), speed, 1e-4 * speed);
}

/// Seconds of flowing that the matter of a free jet amounts to.
double flowed(const std::vector<scene::Switch>& switches, double seconds) {
    scene::Scene scene = jet_scene(0.03, 1);
    scene.emitters[0].switches = switches;
    const double rate = kPi * square(0.03) * 1 / cube(0.01);
    return static_cast<double>(free_jet(scene, seconds, 0.0007).size()) / rate;
}

TEST(Emitter, FlowsWhileItIsOn) {
    // A layer, 0.9 spacings, flows for 9 ms.
    const double layer = static_cast<double>(packing_layer(Real(0.01)));
    EXPECT_NEAR(flowed({{0.1, false}, {0.3, true}}, 0.5), 0.3, layer);
    EXPECT_NEAR(flowed({{0.1, false}}, 0.5), 0.1, layer);
    EXPECT_NEAR(flowed({{0, false}, {0.2, true}}, 0.5), 0.3, layer);
    EXPECT_NEAR(flowed({{0, false}}, 0.5), 0, 0);
    EXPECT_NEAR(flowed({{0.1, true}, {0.2, true}}, 0.5), 0.5, layer);
}

TEST(Emitter, LosesNothingByBeingSwitchedOften) {
    // On for 4 ms of every 8: each time half a layer, which the next time completes.
    std::vector<scene::Switch> switches;
    for (int k = 0; k < 100; ++k) switches.push_back({0.004 * (k + 1), k % 2 == 1});
    EXPECT_NEAR(flowed(switches, 0.4), 0.2, static_cast<double>(packing_layer(Real(0.01))));
    scene::Emitter e;
    e.switches = switches;
    EXPECT_NEAR(flow_seconds(e, 0.4), 0.2, 1e-12);
}

TEST(Emitter, ReleasesNothingBetweenSwitches) {
    scene::Scene scene = jet_scene(0.03, 1);
    scene.world.gravity = {0, 0, 0};
    scene.emitters[0].switches = {{0.1, false}, {0.3, true}};
    // What left the disc at time t is at -(0.5 - t) now: nothing of 0.1 < t < 0.3, but for a layer's width.
    for (const Vec3& x : free_jet(scene, 0.5, 0.0005).position) {
        const double left_at = 0.5 + static_cast<double>(x.z());
        EXPECT_TRUE(left_at < 0.11 || left_at > 0.29) << left_at;
    }
}

/// A jet of speed 1 m/s through a shape's cut at z = 0.
Particles jet_through(const scene::Shape& shape, double seconds) {
    scene::Scene scene = jet_scene(0.05, 1);
    scene.emitters[0].shape = shape;
    return free_jet(scene, seconds, 0.0005);
}

TEST(Emitter, FillsTheCutOfAShape) {
    // Boxes, a ring, a slanted cylinder: area times speed.
    scene::Shape slit = fixture::shape_at({0.02, 0, 0.01}, scene::BoxShape{{0.2, 0.04, 0.1}, 0});
    scene::Shape ring = fixture::shape_at({0, 0, 0}, scene::Torus{0.06, 0.02});
    scene::Shape slanted = fixture::shape_at({0, 0, 0}, scene::Cylinder{0.04, 1, 0});
    slanted.rotate = {0, 60, 0};
    const double seconds = 0.4;
    for (const auto& [shape, area] : {std::pair(slit, 0.2 * 0.04),
                                      {ring, kPi * (square(0.08) - square(0.04))},
                                      {slanted, kPi * square(0.04) / std::cos(kPi / 3)}}) {
        const double expected = area * seconds / cube(0.01);
        EXPECT_NEAR(static_cast<double>(jet_through(shape, seconds).size()), expected, 0.03 * expected);
    }
}

TEST(Emitter, ReleasesInsideTheCutAlone) {
    for (const Vec3& x : jet_through(fixture::shape_at({0, 0, 0}, scene::Torus{0.06, 0.02}), 0.2).position) {
        EXPECT_GT(std::hypot(x.x(), x.y()), 0.0399);
        EXPECT_LT(std::hypot(x.x(), x.y()), 0.0801);
    }
}

TEST(Emitter, RefusesAShapeThatItsPlaneMisses) {
    scene::Scene scene = jet_scene(0.05, 1);
    scene.emitters[0].shape = fixture::shape_at({0, 0, 1}, scene::Sphere{0.1});
    EXPECT_THROW(make_simulation(scene), InputError);
    scene.emitters[0].shape = fixture::shape_at({0, 0, 0}, scene::Plane{});
    EXPECT_THROW(make_simulation(scene), InputError);
}

TEST(Emitter, RefusesADiscThinnerThanAParticle) { EXPECT_THROW(make_simulation(jet_scene(0.001, 1)), InputError); }

}  // namespace
}  // namespace thixo
