#include "sim/liquid/leapfrog.h"

#include <gtest/gtest.h>

#include "tests/sim/fixture.h"

namespace thixo {
namespace {

TEST(Leapfrog, FreeFallIsExact) {
    // A single particle moves under gravity, with steps that change. Leapfrog is exact for a constant force: x = v0 t +
    // g t^2/2 to rounding.
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.bodies = {fixture::body("drop", fixture::shape_at({0, 0, 0}, scene::Sphere{0.004}), {0.3, 0, 1})};
    Simulation s = make_simulation(scene);
    ASSERT_EQ(s.particles.size(), 1u);
    const Vec3d start = s.particles.position[0].cast<double>();
    for (const double dt : {1e-3, 3e-4, 2e-3, 1e-3, 7e-4}) fixture::steps(s, 20, dt);
    const double t = s.clock.time;
    const Vec3d expected = start + Vec3d(0.3, 0, 1) * t + 0.5 * Vec3d(0, 0, -9.81) * t * t;
    const double rounding = sizeof(Real) == 8 ? 1e-13 : 2e-6;  // 100 additions to a coordinate of about 0.1 m
    EXPECT_LT((s.particles.position[0].cast<double>() - expected).norm(), rounding);
}

TEST(Leapfrog, EmittedParticlesFallFreelyFromTheDisc) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene::Emitter e;
    e.name = "spout";
    e.material = "water";
    e.radius = 0.012;
    e.speed = 0.7;
    e.stop = 1e-9;  // one layer, at time 0
    scene.emitters = {e};
    scene.materials[0].viscosity = 0;
    scene.solver.artificial_viscosity = 0;
    Simulation s = make_simulation(scene);
    fixture::steps(s, 100, 1e-3);
    ASSERT_GT(s.particles.size(), 1u);
    for (const Vec3& x : s.particles.position) EXPECT_NEAR(x.z(), -0.7 * 0.1 - 0.5 * 9.81 * 0.01, 2e-6);
}

#ifdef THIXO_DOUBLE
TEST(Leapfrog, RunsBackToWhereItBegan) {
    // A ball of liquid makes 200 steps under pressure and cohesion, without viscosity. Then the velocities are
    // reversed.
    scene::Scene scene = fixture::empty_space();
    scene.materials[0].viscosity = 0;
    scene.materials[0].surface_tension = 0.07;
    scene.solver.artificial_viscosity = 0;
    scene.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0}, scene::Ellipsoid{{0.06, 0.04, 0.03}}))};
    Simulation s = make_simulation(scene);
    const auto by_id = [](const Particles& p) {
        std::vector<Vec3> x(p.size());
        for (std::size_t i = 0; i < p.size(); ++i) x[static_cast<std::size_t>(p.id[i])] = p.position[i];
        return x;
    };
    const double dt = 2e-4;
    const std::vector<Vec3> start = by_id(s.particles);
    fixture::steps(s, 201, dt);
    const std::vector<Vec3> middle = by_id(s.particles);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        s.particles.position[i] -=
            dt * s.particles.velocity[i];  // the state between: x(t), and v(t + dt/2) turned round
        s.particles.velocity[i] = -s.particles.velocity[i];
    }
    fixture::steps(s, 200, dt);
    const std::vector<Vec3> end = by_id(s.particles);
    double moved = 0, off = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
        moved = std::max(moved, (middle[i] - start[i]).norm());
        off = std::max(off, (end[i] - start[i]).norm());
    }
    EXPECT_GT(moved, 1e-4);       // it was a motion
    EXPECT_LT(off, 1e-3 * 0.01);  // 1e-3 spacings: rounding in double, grown by the flow
}
#endif

}  // namespace
}  // namespace thixo
