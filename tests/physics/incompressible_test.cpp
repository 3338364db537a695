// Laws that the implicit pressure solver keeps.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

scene::Scene implicit(scene::Scene scene) {
    scene.solver.pressure = scene::Pressure::dfsph;
    return scene;
}

double root_mean_square(const std::vector<Vec3>& v) {
    double sum = 0;
    for (const Vec3& a : v) sum += static_cast<double>(a.squaredNorm());
    return std::sqrt(sum / static_cast<double>(v.size()));
}

TEST(Incompressible, MomentumIsConserved) {
    scene::Scene scene = implicit(fixture::empty_space());
    scene.materials[0].viscosity = 0;
    scene.bodies = {fixture::body("left", fixture::shape_at({-0.045, 0.01, 0}, scene::Sphere{0.04}), {0.3, 0, 0}),
                    fixture::body("right", fixture::shape_at({0.045, -0.01, 0}, scene::Sphere{0.04}), {-0.3, 0, 0})};
    Simulation s = make_simulation(scene);
    const Vec3d linear = fixture::momentum(s.particles), angular = fixture::angular_momentum(s.particles);
    const double scale = fixture::motion(s.particles);
    fixture::steps(s, 1000, 5e-4);
    const double lost = (fixture::momentum(s.particles) - linear).norm() / scale;
    const double turned = (fixture::angular_momentum(s.particles) - angular).norm() / (0.05 * scale);
    fmt::print("two balls collide, 1000 steps: linear {:.2e} of sum m|v|, angular {:.2e}\n", lost, turned);
    // Rounding: 6e-8 sqrt(1000 n)/n of each kick.
    EXPECT_LT(lost, 1e-6);
    // Pressure acts along the line of a pair and keeps the angular momentum. The shifts of the density solve move x and
    // not v, and do not keep it. This is a bound on those shifts.
    EXPECT_LT(turned, 1e-2);
}

TEST(Incompressible, ADropFallsFreely) {
    scene::Scene scene = implicit(fixture::empty_space());
    scene.world.gravity = {0, 0, -9.81};
    scene.bodies = {fixture::body("drop", fixture::shape_at({0, 0, 0}, scene::Sphere{0.04}), {0.5, 0, 0})};
    Simulation s = make_simulation(scene);
    Vec3d before(0, 0, 0), after(0, 0, 0);
    for (const Vec3& x : s.particles.position) before += x.cast<double>() / static_cast<double>(s.particles.size());
    for (int f = 0; f < 12; ++f) advance_frame(s);
    for (const Vec3& x : s.particles.position) after += x.cast<double>() / static_cast<double>(s.particles.size());
    const Vec3d expected = before + Vec3d(0.25, 0, -0.5 * 9.81 * 0.25);
    fmt::print("centre off by {:.2e} m after 0.5 s\n", (after - expected).norm());
    // With its first half step, leapfrog is exact under a constant force. Positions of a metre are rounded by 6e-8 in
    // each of 200 steps.
    EXPECT_LT((after - expected).norm(), 2e-5);
}

TEST(Incompressible, ACompressedBlockComesBack) {
    scene::Scene scene = implicit(fixture::empty_space());
    scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.1, 0.1, 0.1}, 0}))};
    Simulation s = make_simulation(scene);
    for (Vec3& x : s.particles.position) x *= Real(std::cbrt(0.97));
    evaluate(s);
    const auto error = [&] {
        double sum = 0;
        for (const Real rho : s.particles.density) sum += std::max(static_cast<double>(rho) / 1000 - 1, 0.0);
        return sum / static_cast<double>(s.particles.size());
    };
    const double before = error();
    fixture::steps(s, 40, 2e-3);
    evaluate(s);
    fmt::print("mean compression {:.4f} before, {:.5f} after 40 steps; speed left {:.4f} m/s\n", before, error(),
               root_mean_square(s.particles.velocity));
    EXPECT_LT(error(), 2 * scene.solver.density_tolerance);
    // Density is restored by displacements, so that no particle gains speed.
    EXPECT_LT(root_mean_square(s.particles.velocity), 0.01);
}

}  // namespace
}  // namespace thixo
