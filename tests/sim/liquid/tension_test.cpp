#include "sim/liquid/tension.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/random.h"
#include "pipeline/geometry/shapes.h"
#include "sim/space/sampling.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

// The accelerations of tension alone.
void pull(Simulation& s) {
    evaluate(s);
    for (Vec3& a : s.particles.acceleration) a.setZero();
    add_tension(s.particles, {s.neighbours, s.walls, s.problem.smoothing, s.sweep}, s.problem.tension,
                s.problem.materials, s.tension);
}

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
    pull(s);
    return s;
}

TEST(Tension, IsTheStressOfItsSurfaceWithoutItsTorques) {
    // The formulas of the header, every pair summed plainly.
    const Simulation s = shaken_ball();
    const Particles& p = s.particles;
    const std::size_t n = p.size();
    const Poly6& w = s.problem.smoothing.density;
    const TensionScale& scale = s.problem.tension;
    const auto between = [&](std::size_t i, std::size_t j) { return Vec3(p.position[i] - p.position[j]); };
    const auto weight = [&](std::size_t i, std::size_t j) { return w.value(between(i, j).squaredNorm()); };
    const auto slope = [&](std::size_t i, std::size_t j) {
        return Vec3(w.gradient_factor(between(i, j).squaredNorm()) * between(i, j));
    };
    std::vector<Real> colour(n), volume(n), taking(n);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) colour[i] += p.rest_volume[j] * weight(i, j);
        volume[i] = p.rest_volume[i] / std::max(colour[i], Real(0.5));
        taking[i] = std::clamp((colour[i] - Real(0.5)) / Real(0.1), Real(0), Real(1));
    }
    std::vector<Mat3> stress(n), moment(n);
    std::vector<Vec3> torque(n), couple(n);
    for (std::size_t i = 0; i < n; ++i) {
        Vec3 g(0, 0, 0);
        moment[i].setZero();
        Real taken = volume[i] * w.value(0);
        for (std::size_t j = 0; j < n; ++j) {
            g += volume[j] * slope(i, j);
            moment[i] -= volume[j] * slope(i, j) * between(i, j).transpose();
            if (j != i) taken += taking[j] * volume[j] * weight(i, j);
        }
        const Mat3 surface = g.norm() * Mat3::Identity() - g * g.transpose() / g.norm();
        stress[i] = s.problem.materials[static_cast<std::size_t>(p.material[i])].tension *
                    (scale.stress * surface + scale.deficit * std::max(1 - colour[i], Real(0)) * Mat3::Identity());
        const Mat3 t = stress[i] * moment[i];
        torque[i] = volume[i] / taken * Vec3(t(2, 1) - t(1, 2), t(0, 2) - t(2, 0), t(1, 0) - t(0, 1));
    }
    for (std::size_t i = 0; i < n; ++i) {
        Vec3 sum = w.value(0) * torque[i];
        for (std::size_t j = 0; j < n; ++j)
            if (j != i) sum += taking[i] * weight(i, j) * torque[j];
        couple[i] = (moment[i].trace() * Mat3::Identity() - moment[i]).inverse() * sum;
    }
    Real largest = 0, worst = 0;
    for (std::size_t i = 0; i < n; i += 7) {
        Vec3 a(0, 0, 0);
        for (std::size_t j = 0; j < n; ++j)
            a += volume[i] * volume[j] / p.mass[i] *
                 ((stress[i] + stress[j]) * slope(i, j) - (couple[i] + couple[j]).cross(slope(i, j)));
        largest = std::max(largest, a.norm());
        worst = std::max(worst, (a - p.acceleration[i]).norm());
    }
    EXPECT_LT(worst, 1e-4 * largest);  // sums of some 30 terms in float, five of them in a row
}

TEST(Tension, KeepsBothMomenta) {
    const Simulation s = shaken_ball();
    Vec3d force(0, 0, 0), torque(0, 0, 0);
    double scale = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Vec3d f = static_cast<double>(s.particles.mass[i]) * s.particles.acceleration[i].cast<double>();
        force += f;
        torque += s.particles.position[i].cast<double>().cross(f);
        scale += f.norm();
    }
    // The two forces of every pair are opposite to rounding, 6e-8 of each. The torques of stencils are taken away
    // through sums of floats.
    EXPECT_LT(force.norm(), 1e-6 * scale);
    EXPECT_LT(torque.norm(), 1e-5 * 0.05 * scale);
}

TEST(Tension, LeavesALiquidsInsideAlone) {
    // The force on a particle inside a packing is negligible beside that on a particle of its surface.
    scene::Scene scene = fixture::empty_space();
    const Vec3d size = 12 * packing_steps(Real(0.01));  // of whole rows: the packing is not stretched
    scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{size, 0}))};
    scene.materials[0].surface_tension = 0.07;
    Simulation s = make_simulation(scene);
    pull(s);
    Real inside = 0, outside = 0;
    const Shape inner = box(size - Vec3d::Constant(3 * static_cast<double>(s.problem.smoothing.support)));
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const bool deep = inner.distance(s.particles.position[i]) < 0;
        Real& most = deep ? inside : outside;
        most = std::max(most, s.particles.acceleration[i].norm());
    }
    EXPECT_GT(outside, 0);
    EXPECT_LT(inside, 2e-3 * outside);  // rounding of sums of 30 terms that cancel
}

TEST(Tension, AWallPullsAsItsContactAngleSays) {
    // A packing wets a floor at the angle theta. Its approach from infinity does the work per area
    //     gamma (1 + cos theta)  [N/m]
    // The walls' tables are linear in cells of h/4. They give up to a tenth more than the integral of the convex
    // kernel.
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
            pull(s);
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
