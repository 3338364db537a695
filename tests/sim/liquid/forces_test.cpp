#include "sim/liquid/forces.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "sim/space/sampling.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

// A ball of water whose particles move at random, up to `speed` along each axis.
Simulation stirred_ball(const scene::Scene& scene, double speed) {
    Simulation s = make_simulation(scene);
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        for (int a = 0; a < 3; ++a)
            s.particles.velocity[i][a] =
                static_cast<Real>(speed * (2 * random_unit(7, static_cast<std::uint64_t>(s.particles.id[i]), 0,
                                                           static_cast<std::uint64_t>(a)) -
                                           1));
    return s;
}

scene::Scene ball(double radius = 0.05) {
    scene::Scene scene = fixture::empty_space();
    scene.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0}, scene::Sphere{radius}))};
    return scene;
}

TEST(Forces, LinearMomentumIsConservedOverAThousandSteps) {
    scene::Scene scene = ball();
    scene.materials[0].viscosity = 0.5;
    scene.materials[0].surface_tension = 0.07;
    Simulation s = stirred_ball(scene, 0.5);
    // In each step each of n particles rounds its velocity by 6e-8, at random. Over 1000 steps this gives, of sum m|v|,
    //     6e-8 sqrt(1000 n)/n
    const Vec3d before = fixture::momentum(s.particles);
    const double scale = fixture::motion(s.particles);
    fixture::steps(s, 1000, 1e-4);
    EXPECT_LT((fixture::momentum(s.particles) - before).norm(), 1e-6 * scale);
}

TEST(Forces, ViscosityConservesMomentumAndTakesEnergy) {
    scene::Scene scene = ball();
    scene.materials[0].viscosity = 5;
    scene.materials[0].stiffness = 1e-3;  // viscosity alone: next to no pressure
    scene.solver.artificial_viscosity = 0;
    Simulation s = stirred_ball(scene, 0.1);
    const auto energy = [](const Particles& p) {
        double sum = 0;
        for (std::size_t i = 0; i < p.size(); ++i)
            sum += 0.5 * static_cast<double>(p.mass[i] * p.velocity[i].squaredNorm());
        return sum;
    };
    const Vec3d before = fixture::momentum(s.particles);
    const double scale = fixture::motion(s.particles);
    double last = energy(s.particles);
    for (int k = 0; k < 50; ++k) {
        fixture::steps(s, 1, 1e-4);
        EXPECT_LT(energy(s.particles), last);
        last = energy(s.particles);
    }
    EXPECT_LT((fixture::momentum(s.particles) - before).norm(), 1e-6 * scale);
}

TEST(Forces, PressureKeepsAngularMomentum) {
    scene::Scene scene = ball();
    scene.materials[0].viscosity = 0;
    scene.solver.artificial_viscosity = 0;
    Simulation s = stirred_ball(scene, 0.5);
    const Vec3d before = fixture::angular_momentum(s.particles);
    fixture::steps(s, 200, 1e-4);
    // Central forces keep x cross v exactly at each kick, and each drift adds v cross v = 0. Only rounding remains,
    // relative to radius sum m|v|.
    EXPECT_LT((fixture::angular_momentum(s.particles) - before).norm(), 1e-5 * 0.05 * fixture::motion(s.particles));
}

TEST(Forces, AgreeWithTheFormulaWrittenPlainly) {
    scene::Scene scene = ball(0.04);
    scene.materials[0].viscosity = 0.3;
    scene.materials[0].surface_tension = 0.07;
    Simulation s = stirred_ball(scene, 1);
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        s.particles.position[i] += Real(0.002) * s.particles.velocity[i];
    evaluate(s);
    compute_accelerations(s.particles, s.neighbours, s.problem.smoothing, {Vec3(0, 0, -1), Real(0.05)}, s.sweep);
    const Particles& p = s.particles;
    const double h = s.problem.smoothing.support, soft = 0.01 * 0.25 * h * h,
                 sound = s.problem.materials[0].sound_speed;
    const double calibrated_gradient = 1 / packed_gradient(Spiky(static_cast<Real>(h)), s.problem.smoothing.spacing);
    const double calibrated_laplacian =
        1 / packed_laplacian(ViscosityKernel(static_cast<Real>(h)), s.problem.smoothing.spacing);
    double largest = 0, worst = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        Vec3d f(0, 0, 0);
        const double vi = p.mass[i] / std::max(p.density[i], Real(1000));
        for (std::size_t j = 0; j < p.size(); ++j) {
            const Vec3d r = (p.position[i] - p.position[j]).cast<double>();
            const double l = r.norm();
            if (j == i || l >= h) continue;
            const Vec3d u = (p.velocity[i] - p.velocity[j]).cast<double>();
            const double vj = p.mass[j] / std::max(p.density[j], Real(1000));
            const Vec3d grad = -calibrated_gradient * 45 / (kPi * std::pow(h, 4)) * square(1 - l / h) * r / l;
            const double lap = calibrated_laplacian * 45 / (kPi * std::pow(h, 5)) * (1 - l / h);
            const double artificial = 0.05 * 1000 * sound * h / 2 * std::min(u.dot(r), 0.0) / (l * l + soft);
            f += vi * vj * ((artificial - static_cast<double>(p.pressure[i] + p.pressure[j])) * grad - 0.3 * lap * u);
        }
        const Vec3d a = Vec3d(0, 0, -1) + f / static_cast<double>(p.mass[i]);
        largest = std::max(largest, a.norm());
        worst = std::max(worst, (a - p.acceleration[i].cast<double>()).norm());
    }
    // Sums of some 30 terms that largely cancel, in float: 1e-5 of the largest.
    EXPECT_LT(worst, 1e-5 * largest);
}

}  // namespace
}  // namespace thixo
