#include "sim/sources/emitter.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
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

TEST(Emitter, RefusesADiscThinnerThanAParticle) { EXPECT_THROW(make_simulation(jet_scene(0.001, 1)), InputError); }

}  // namespace
}  // namespace thixo
