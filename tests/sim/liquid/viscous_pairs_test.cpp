#include "sim/liquid/viscous_pairs.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "sim/space/sampling.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

constexpr double kRadius = 0.04;

// A ball of two liquids side by side whose particles move and lie at random.
Simulation ball_of_two_liquids(double viscosity, double speed) {
    scene::Scene scene = fixture::empty_space();
    scene.solver.pressure = scene::Pressure::dfsph;
    scene.solver.viscosity = scene::Viscosity::explicit_force;
    scene.materials[0].viscosity = viscosity;
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].name = "thin";
    scene.materials[1].viscosity = viscosity / 3;
    scene.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0}, scene::Sphere{kRadius}))};
    Simulation s = make_simulation(scene);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        s.particles.material[i] = s.particles.position[i].x() > 0;
        for (int a = 0; a < 3; ++a) {
            const auto lane = static_cast<std::uint64_t>(a);
            s.particles.velocity[i][a] = static_cast<Real>(speed * (2 * random_unit(7, i, 0, lane) - 1));
            s.particles.position[i][a] += static_cast<Real>(0.002 * random_unit(3, i, 0, lane));
        }
    }
    evaluate(s);
    compute_viscous_accelerations(s.particles, {s.neighbours, s.walls, s.problem.smoothing, s.sweep}, {Vec3(0, 0, -1)});
    return s;
}

TEST(ViscousPairs, AgreeWithTheFormulaWrittenPlainly) {
    const Simulation s = ball_of_two_liquids(0.3, 1);
    const Particles& p = s.particles;
    const double h = s.problem.smoothing.support;
    const double scale = 1 / packed_gradient(Poly6(static_cast<Real>(h)), s.problem.smoothing.spacing);
    double largest = 0, worst = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        Vec3d f(0, 0, 0);
        const double vi = s.sweep.motion[i].w, mi = p.material[i] ? 0.1 : 0.3;
        for (std::size_t j = 0; j < p.size(); ++j) {
            const Vec3d r = (p.position[i] - p.position[j]).cast<double>();
            const double l = r.norm(), vj = s.sweep.motion[j].w, mj = p.material[j] ? 0.1 : 0.3;
            if (j == i || l >= h) continue;
            const Vec3d u = (p.velocity[i] - p.velocity[j]).cast<double>();
            // 2 |dw/dr|/r of poly6, scaled over the packing
            const double k = scale * 2 * 945 / (32 * kPi * std::pow(h, 5)) * square(1 - square(l / h));
            f -= 5 * vi * vj * 2 * mi * mj / (mi + mj) * k * u.dot(r) / (l * l) * r;
        }
        const Vec3d a = Vec3d(0, 0, -1) + f / static_cast<double>(p.mass[i]);
        largest = std::max(largest, a.norm());
        worst = std::max(worst, (a - p.acceleration[i].cast<double>()).norm());
    }
    EXPECT_LT(worst, 1e-5 * largest);  // sums of some 30 terms in float
}

TEST(ViscousPairs, KeepBothMomenta) {
    const Simulation s = ball_of_two_liquids(5, 0.5);
    Vec3d force(0, 0, 0), torque(0, 0, 0);
    double scale = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3d a = s.particles.acceleration[i].cast<double>() + Vec3d(0, 0, 1);
        const Vec3d f = static_cast<double>(s.particles.mass[i]) * a;
        force += f;
        torque += s.particles.position[i].cast<double>().cross(f);
        scale += f.norm();
    }
    EXPECT_LT(force.norm(), 1e-6 * scale);
    EXPECT_LT(torque.norm(), 1e-6 * kRadius * scale);
}

TEST(ViscousPairs, LeaveARigidRotationAlone) {
    Simulation s = ball_of_two_liquids(5, 0);
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        s.particles.velocity[i] = Vec3(0, 0, 10).cross(s.particles.position[i]);
    evaluate(s);
    compute_viscous_accelerations(s.particles, {s.neighbours, s.walls, s.problem.smoothing, s.sweep}, {});
    // A shear of 10/s would give some mu 10/(rho h) of acceleration.
    for (const Vec3& a : s.particles.acceleration) EXPECT_LT(a.norm(), 1e-4 * 5 * 10 / (1000 * 0.02));
}

}  // namespace
}  // namespace thixo
