#include "sim/tension.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "sim/sampling.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

// Two liquids side by side in a shaken ball.
Simulation shaken_ball() {
    scene::Scene scene = fixture::empty_space();
    scene.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0}, scene::Sphere{0.04}))};
    scene.materials[0].surface_tension = 0.07;
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].surface_tension = 0.02;
    Simulation s = make_simulation(scene);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        s.particles.material[i] = s.particles.position[i].x() > 0;
        for (int a = 0; a < 3; ++a)
            s.particles.position[i][a] +=
                static_cast<Real>(0.003 * random_unit(3, i, 0, static_cast<std::uint64_t>(a)));
    }
    evaluate(s);
    for (Vec3& a : s.particles.acceleration) a.setZero();
    add_tension(s.particles, s.neighbours, s.walls, s.problem.smoothing, s.problem.materials, s.sweep, s.tension);
    return s;
}

TEST(Tension, KernelIntegratesToOneAndItsSlopeIsItsDerivative) {
    const CohesionKernel kernel(Real(0.02));
    double sum = 0;
    constexpr int kSteps = 2000;
    for (int k = 0; k < kSteps; ++k) {
        const double r = 0.02 * (k + 0.5) / kSteps;
        sum += static_cast<double>(kernel.value(static_cast<Real>(r))) * 4 * kPi * r * r * 0.02 / kSteps;
    }
    EXPECT_NEAR(sum, 1, 1e-4);  // float values, midpoint sums
    const double scale = static_cast<double>(kernel.value(0)) / 0.02;
    for (const double q : {0.1, 0.3, 0.5, 0.8}) {
        const double r = 0.02 * q, step = 0.02 * 0.01;
        const double difference = static_cast<double>(kernel.value(static_cast<Real>(r + step)) -
                                                      kernel.value(static_cast<Real>(r - step))) /
                                  (2 * step);
        EXPECT_NEAR(-static_cast<double>(kernel.slope) * r * q * q * cube(1 - q), difference, 2e-3 * scale);
    }
}

TEST(Tension, IsTheGradientOfItsEnergy) {
    // Every pair of energy -q_i q_j w(r), by its slope, summed plainly.
    const Simulation s = shaken_ball();
    const CohesionKernel kernel(s.problem.smoothing.support);
    const Particles& p = s.particles;
    const auto charge = [&](std::size_t i) {
        const auto& m = s.problem.materials[static_cast<std::size_t>(p.material[i])];
        return std::sqrt(static_cast<double>(m.attraction)) * static_cast<double>(p.mass[i]);
    };
    double largest = 0, worst = 0;
    for (std::size_t i = 0; i < p.size(); i += 7) {
        Vec3d force(0, 0, 0);
        for (std::size_t j = 0; j < p.size(); ++j) {
            if (j == i) continue;
            const Vec3d r = (p.position[i] - p.position[j]).cast<double>();
            const double q = r.norm() * static_cast<double>(kernel.h_inv);
            if (q < 1) force -= charge(i) * charge(j) * static_cast<double>(kernel.slope) * q * q * cube(1 - q) * r;
        }
        const Vec3d a = force / static_cast<double>(p.mass[i]);
        largest = std::max(largest, a.norm());
        worst = std::max(worst, (a - p.acceleration[i].cast<double>()).norm());
    }
    EXPECT_LT(worst, 1e-5 * largest);  // sums of some 30 terms in float
}

TEST(Tension, KeepsLinearAndAngularMomentum) {
    const Simulation s = shaken_ball();
    Vec3d force(0, 0, 0), torque(0, 0, 0);
    double scale = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3d f = static_cast<double>(s.particles.mass[i]) * s.particles.acceleration[i].cast<double>();
        force += f;
        torque += s.particles.position[i].cast<double>().cross(f);
        scale += f.norm();
    }
    // Every pair's force is equal and opposite to rounding, 6e-8 of each.
    EXPECT_LT(force.norm(), 1e-6 * scale);
    EXPECT_LT(torque.norm(), 1e-6 * 0.05 * scale);
}

TEST(Tension, PartingAPackingCostsTwiceTheSurfaceTensionOfTheScene) {
    const Smoothing smoothing(Real(0.01), 2);
    const CohesionKernel kernel(smoothing.support);
    const Real d = smoothing.spacing, k = attraction_for(Real(0.07), 1000, smoothing);
    double work = 0;  // of one column of sites: layers below against layers from 0 on
    for (int below = 1; below <= 4; ++below)
        for (int above = 0; above <= 4; ++above)
            for (int j = -6; j <= 6; ++j)
                for (int i = -6; i <= 6; ++i)
                    work += static_cast<double>(k) * square(1000 * cube(static_cast<double>(d))) *
                            static_cast<double>(kernel.value(
                                (packing_site(i, j, above, d) - packing_site(0, 0, -below, d)).norm()));
    const double area = cube(static_cast<double>(d)) / static_cast<double>(packing_layer(d));
    EXPECT_NEAR(work / area / 2, 0.07, 1e-5);
}

TEST(Tension, AWallPullsAsItsContactAngleSays) {
    // A packing beside a floor it wets at theta: the work of its approach from infinity is gamma (1 + cos theta) a unit
    // area. The walls' tables, linear in cells of h/4, give up to a tenth more than the integral of the convex kernel.
    for (const double angle : {30.0, 90.0, 150.0, 180.0}) {
        scene::Scene scene = fixture::empty_space();
        scene.materials[0].surface_tension = 0.07;
        scene::Boundary floor;
        floor.name = "floor";
        floor.contact_angle = angle;
        floor.shape.kind = scene::Plane{{0, 0, 1}, 0};
        scene.world.boundaries = {floor};
        const double d = 0.01, layer = static_cast<double>(packing_layer(Real(d)));
        scene.bodies = {
            fixture::body("block", fixture::shape_at({0, 0, 2 * layer}, scene::BoxShape{{0.06, 0.06, 4 * layer}, 0}))};
        Simulation s = make_simulation(scene);
        const std::vector<Vec3> packed = s.particles.position;
        const auto normal_force = [&] {
            evaluate(s);
            for (Vec3& a : s.particles.acceleration) a.setZero();
            add_tension(s.particles, s.neighbours, s.walls, s.problem.smoothing, s.problem.materials, s.sweep,
                        s.tension);
            double sum = 0;
            for (std::size_t i = 0; i < s.particles.size(); ++i)
                sum += static_cast<double>(s.particles.mass[i] * s.particles.acceleration[i].z());
            return sum;
        };
        constexpr int kSteps = 200;
        const double reach = 0.02;
        double work = 0;
        for (int k = 0; k < kSteps; ++k) {
            for (std::size_t i = 0; i < packed.size(); ++i)
                s.particles.position[i] = packed[i] + Vec3(0, 0, static_cast<Real>(reach * (k + 0.5) / kSteps));
            work -= normal_force() * reach / kSteps;
        }
        // Area of the block: its particles of one layer.
        const double area = static_cast<double>(packed.size()) / 4 * cube(d) / layer;
        EXPECT_NEAR(work / area, 0.07 * (1 + std::cos(angle * kPi / 180)), 0.12 * 0.14) << angle;
    }
}

}  // namespace
}  // namespace thixo
