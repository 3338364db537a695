#include "sim/liquid/viscosity_solver.h"

#include <gtest/gtest.h>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "sim/liquid/viscous_pairs.h"
#include "sim/loop/time_step.h"
#include "sim/stage/checkpoint.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

scene::Scene thick_ball(double viscosity, double radius = 0.05) {
    scene::Scene scene = fixture::empty_space();
    scene.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0}, scene::Sphere{radius}))};
    scene.materials[0].viscosity = viscosity;
    scene.solver.artificial_viscosity = 0;
    scene.solver.viscosity = scene::Viscosity::implicit_solve;
    return scene;
}

void stir(Simulation& s, double speed) {
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        for (int a = 0; a < 3; ++a)
            s.particles.velocity[i][a] +=
                static_cast<Real>(speed * (2 * random_unit(7, static_cast<std::uint64_t>(s.particles.id[i]), 0,
                                                           static_cast<std::uint64_t>(a)) -
                                           1));
}

double energy(const Particles& p) {
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i)
        sum += 0.5 * static_cast<double>(p.mass[i] * p.velocity[i].squaredNorm());
    return sum;
}

// One implicit solve from the current velocities, without any other force. Velocities become the new ones.
ViscosityReport solve_alone(Simulation& s, double dt, double tolerance) {
    evaluate(s);
    Particles& p = s.particles;
    for (std::size_t i = 0; i < p.size(); ++i) p.acceleration[i] = p.viscous_acceleration[i] = Vec3::Zero();
    const ViscosityReport report =
        solve_viscosity(p, {s.neighbours, s.walls, s.problem.smoothing, s.sweep}, s.problem.materials,
                        {.kick = dt, .tolerance = tolerance}, s.viscosity);
    for (std::size_t i = 0; i < p.size(); ++i) p.velocity[i] += static_cast<Real>(dt) * p.acceleration[i];
    return report;
}

TEST(ViscositySolver, SolvesTheFormulaWrittenPlainly) {
    // Each half of a stirred ball is a liquid; their viscosities differ by a factor of a thousand.
    scene::Scene scene = thick_ball(100);
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].viscosity = 0.1;
    Simulation s = make_simulation(scene);
    for (std::size_t i = 0; i < s.particles.size(); ++i) s.particles.material[i] = s.particles.position[i].x() > 0;
    stir(s, 1);
    std::vector<Vec3d> before(s.particles.size());
    evaluate(s);  // brings the particles into the order they keep
    for (std::size_t i = 0; i < before.size(); ++i) before[i] = s.particles.velocity[i].cast<double>();
    const double dt = 1e-3;
    const ViscosityReport report = solve_alone(s, dt, 1e-5);
    EXPECT_TRUE(report.converged);
    const Particles& p = s.particles;
    const double h = s.problem.smoothing.support;
    const double scale =
        945 / (16 * kPi * std::pow(h, 5)) / packed_gradient(Poly6(static_cast<Real>(h)), s.problem.smoothing.spacing);
    const auto kernel = [&](double r) { return r < h ? scale * square(1 - square(r / h)) : 0; };
    const auto volume = [&](std::size_t i) {
        return static_cast<double>(p.mass[i] / std::max(p.density[i], Real(1000)));
    };
    std::vector<double> even(p.size(), 0);
    for (std::size_t i = 0; i < p.size(); ++i) {
        for (std::size_t j = 0; j < p.size(); ++j) {
            const double r = static_cast<double>((p.position[i] - p.position[j]).norm());
            even[i] += volume(j) * kernel(r) * r * r / 6;
        }
        even[i] = 1 / std::max(even[i], 0.9);
    }
    double residual = 0, target = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const double mu_i = scene.materials[static_cast<std::size_t>(p.material[i])].viscosity;
        Vec3d force(0, 0, 0);
        for (std::size_t j = 0; j < p.size(); ++j) {
            const Vec3d r = (p.position[i] - p.position[j]).cast<double>();
            if (j == i || r.norm() >= h) continue;
            const double mu_j = scene.materials[static_cast<std::size_t>(p.material[j])].viscosity;
            const Vec3d n = r.normalized(), u = (p.velocity[j] - p.velocity[i]).cast<double>();
            force += 5 * volume(i) * volume(j) * 2 * mu_i * mu_j / (mu_i + mu_j) * kernel(r.norm()) *
                     (even[i] + even[j]) / 2 * u.dot(n) * n;
        }
        const Vec3d left = static_cast<double>(p.mass[i]) * (p.velocity[i].cast<double>() - before[i]) - dt * force;
        residual += left.squaredNorm();
        target += (static_cast<double>(p.mass[i]) * before[i]).squaredNorm();
    }
    // The applied acceleration differs from the solution by r/m. The stiffest motions multiply this by dt sum kappa/m,
    // which is about 25 here.
    EXPECT_LT(std::sqrt(residual / target), 50 * 1e-5);
}

TEST(ViscositySolver, WallFrictionIsTheIntegralOverTheHalfSpace) {
    // Midpoint sums over spherical shells and polar angles beyond the plane, 400 each way: 1e-4.
    const double h = 0.02;
    for (const double d : {0.1 * h, 0.25 * h, 0.5 * h, 0.8 * h}) {
        double along = 0, across = 0, all = 0;
        constexpr int kSteps = 400;
        for (int a = 0; a < kSteps; ++a) {
            const double r = d + (h - d) * (a + 0.5) / kSteps;
            for (int b = 0; b < kSteps; ++b) {
                const double least = d / r, c = least + (1 - least) * (b + 0.5) / kSteps;  // cosine to the normal
                const double lap = 45 / (kPi * std::pow(h, 5)) * (1 - r / h);
                const double volume = 2 * kPi * r * r * (h - d) / kSteps * (1 - least) / kSteps;
                all += lap * volume;
                const double k = 945 / (16 * kPi * std::pow(h, 5)) * square(1 - square(r / h));
                along += k * volume * (1 - c * c) / 2 * (r * c / d);
                across += k * volume * c * c * (r * c / d);
            }
        }
        const WallFriction f = wall_friction_of(d, h);
        EXPECT_NEAR(f.along, along / all, 1e-3 * f.along);
        EXPECT_NEAR(f.across, across / all, 1e-3 * f.across);
    }
}

TEST(ViscositySolver, KeepsBothMomentaAtAnyTolerance) {
    // A tolerance of 0.1 leaves a large residual. Pair forces are opposite and along the line of the pair, to rounding.
    // The momenta are relative to sum m|v| and radius sum m|v|, over 100 steps of a few hundred roundings each.
    for (const double tolerance : {0.1, 1e-3}) {
        scene::Scene scene = thick_ball(1000);
        scene.solver.viscosity_tolerance = tolerance;
        scene.bodies[0].angular_velocity = {1, 2, 3};
        Simulation s = make_simulation(scene);
        stir(s, 0.2);
        const Vec3d linear = fixture::momentum(s.particles), angular = fixture::angular_momentum(s.particles);
        const double motion = fixture::motion(s.particles);
        fixture::steps(s, 100, 2e-3);
        EXPECT_LT((fixture::momentum(s.particles) - linear).norm(), 2e-6 * motion);
        EXPECT_LT((fixture::angular_momentum(s.particles) - angular).norm(), 1e-5 * 0.05 * motion);
    }
}

TEST(ViscositySolver, LeavesARigidRotationAlone) {
    scene::Scene scene = thick_ball(1e4);
    scene.bodies[0].angular_velocity = {0, 0, 5};
    Simulation s = make_simulation(scene);
    evaluate(s);
    const std::vector<Vec3> before = s.particles.velocity;
    solve_alone(s, 1e-2, 1e-4);
    double worst = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
        worst = std::max(worst, static_cast<double>((s.particles.velocity[i] - before[i]).norm()));
    // v_ij.x_ij of a rotation is zero but for rounding, 1e-7 of 0.25 m/s, times dt sum kappa/m = 25 000.
    EXPECT_LT(worst, 1e-2 * 5 * 0.05);
}

TEST(ViscositySolver, NeverAddsEnergy) {
    for (const double viscosity : {0.1, 10.0, 1e4}) {
        Simulation s = make_simulation(thick_ball(viscosity));
        stir(s, 0.1);
        double last = energy(s.particles);
        for (int k = 0; k < 20; ++k) {
            solve_alone(s, 2e-3, 1e-3);
            // The rigid motion remains, to rounding.
            EXPECT_LT(energy(s.particles), last * (1 + 1e-6)) << viscosity << " Pa s, solve " << k;
            last = energy(s.particles);
        }
    }
}

TEST(ViscositySolver, AgreesWithTheExplicitForceWhereTheStepIsSmall) {
    // A sinusoidal shear through a periodic block. In a divergence-free flow both are the same Laplacian, up to their
    // discretisation. That gives 1.3 % for the packing's moments, and at most 4 % because the packing is stretched.
    const auto decayed = [](scene::Viscosity solver) {
        scene::Scene scene = fixture::empty_space();
        const double edge = 12 * 0.01 * std::pow(2, 1.0 / 6);
        const double half = edge / 2;
        scene.world.periodic = {
            {scene::Axis::x, -half, half}, {scene::Axis::y, -half, half}, {scene::Axis::z, -half, half}};
        scene.bodies = {fixture::body("block", fixture::shape_at({0, 0, 0}, scene::BoxShape{{edge, edge, edge}, 0}))};
        scene.materials[0].viscosity = 1;
        scene.solver.artificial_viscosity = 0;
        scene.solver.viscosity = solver;
        Simulation s = make_simulation(scene);
        const double k = 2 * kPi / edge;
        const auto amplitude = [&] {
            double sum = 0;
            for (std::size_t i = 0; i < s.particles.size(); ++i)
                sum += static_cast<double>(s.particles.velocity[i].x()) *
                       std::sin(k * static_cast<double>(s.particles.position[i].z()));
            return sum;
        };
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            s.particles.velocity[i].x() =
                static_cast<Real>(0.01 * std::sin(k * static_cast<double>(s.particles.position[i].z())));
        const double before = amplitude();
        fixture::steps(s, 100, 1e-3);
        return -std::log(amplitude() / before);  // nu k^2 t
    };
    const double implicit = decayed(scene::Viscosity::implicit_solve),
                 without = decayed(scene::Viscosity::explicit_force);
    EXPECT_NEAR(implicit, without, 0.04 * without);
}

TEST(ViscositySolver, IsChosenWhereTheExplicitForceWouldSetTheStep) {
    scene::Scene scene = thick_ball(0.01);
    scene.solver.viscosity = scene::Viscosity::automatic;
    EXPECT_EQ(make_simulation(scene).problem.materials[0].implicit_viscosity, 0);
    EXPECT_GT(make_simulation(scene).problem.materials[0].viscosity, 0);
    scene.materials[0].viscosity = 1000;
    Simulation s = make_simulation(scene);
    EXPECT_EQ(s.problem.materials[0].implicit_viscosity, 1000);
    EXPECT_EQ(s.problem.materials[0].viscosity, 0);
    evaluate(s);
    const StepLimits limits =
        step_limits(s.particles, s.sweep, s.problem.materials, s.problem.smoothing, scene.solver.time_step, 0);
    EXPECT_TRUE(std::isinf(limits.viscosity));
    scene.solver.viscosity = scene::Viscosity::explicit_force;
    EXPECT_EQ(make_simulation(scene).problem.materials[0].implicit_viscosity, 0);
}

// A viscous drop falling onto a pool: walls, free surface, impact.
scene::Scene viscous_splash() {
    scene::Scene s = fixture::tank({0.12, 0.12, 0.2}, 0.03, 0.01);
    s.bodies.push_back(fixture::body("drop", fixture::shape_at({0, 0, 0.06}, scene::Sphere{0.02}), {0.1, 0, -1}));
    s.materials[0].viscosity = 20;
    s.world.boundaries[0].no_slip = true;
    s.solver.viscosity = scene::Viscosity::implicit_solve;
    s.frames.fps = 100;
    return s;
}

TEST(ViscositySolver, ResumedAndThreadedRunsAreTheSameBitForBit) {
    std::string whole;
    for (const int threads : {1, 2, 3}) {
        set_thread_count(threads);
        Simulation s = make_simulation(viscous_splash());
        for (int k = 0; k < 4; ++k) advance_frame(s);
        if (whole.empty()) whole = print_checkpoint(s, "hash");
        EXPECT_TRUE(print_checkpoint(s, "hash") == whole) << threads << " threads";
        EXPECT_GT(s.stats.viscosity_iterations, 10);
    }
    set_thread_count(0);
    Simulation first = make_simulation(viscous_splash());
    for (int k = 0; k < 2; ++k) advance_frame(first);
    Simulation second = make_simulation(viscous_splash());
    parse_checkpoint(print_checkpoint(first, "hash"), "half", "hash", second);
    for (int k = 0; k < 2; ++k) advance_frame(second);
    EXPECT_TRUE(print_checkpoint(second, "hash") == whole);
}

}  // namespace
}  // namespace thixo
