// Implicit steps of solids: stable at any length, without gain of energy, and repeatable.
#include "sim/solid/implicit.h"

#include <gtest/gtest.h>

#include "pipeline/base/parallel.h"
#include "sim/solid/laws.h"
#include "sim/solid/stable_step.h"
#include "tests/sim/identity.h"
#include "tests/sim/solid/rubber.h"

namespace thixo {
namespace {

scene::Scene implicit_scene(double modulus) {
    scene::Scene s = fixture::rubber_scene(5);
    s.materials[0].elastic.youngs_modulus = modulus;
    s.solver.solids = scene::SolidSteps::implicit_euler;
    return s;
}

double kinetic(const Simulation& s) {
    double sum = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        sum += static_cast<double>(s.particles.mass[i] * s.particles.velocity[i].squaredNorm()) / 2;
    return sum;
}

TEST(ImplicitSolids, AreStableAtManyTimesTheExplicitStepAndNeverGainEnergy) {
    // A body of 1 GPa spins and vibrates in empty space. The step is 100 times as long as leapfrog's limit.
    scene::Scene scene = implicit_scene(1e9);
    scene.bodies = {fixture::body("block", fixture::shape_at({0.5, 0.2, 0}, scene::BoxShape{{0.1, 0.05, 0.06}, 0}),
                                  {1, -0.5, 0.3})};
    scene.bodies[0].angular_velocity = {5, 20, 10};
    Simulation s = make_simulation(scene);
    const double dt = 0.004;
    Elements& e = s.solids.elements;
    const std::vector<StressLaw> laws{law_at(s.problem.materials[0], 0)};
    set_zero_energy(laws, e);
    const double explicit_step = 2 / std::sqrt(find_stiffest(laws, s.solids.bodies, e)[0]);
    EXPECT_GT(dt, 20 * explicit_step);
    for (std::size_t i = 0; i < e.size(); ++i) {
        const Real by = i % 2 ? Real(0.3) : Real(-0.3);
        e.velocity[i].x += by;
        for (std::size_t k = 0; k < e.size(); ++k)
            if (s.particles.id[k] == e.id[i]) s.particles.velocity[k].x() += by;
    }
    const double before = kinetic(s), motion = fixture::motion(s.particles);
    const Vec3d linear = fixture::momentum(s.particles), angular = fixture::angular_momentum(s.particles);
    double most = 0;
    for (int k = 0; k < 100; ++k) {
        fixture::steps(s, 1, dt);
        most = std::max(most, kinetic(s));
    }
    EXPECT_LE(most, before);
    EXPECT_GT(kinetic(s), 0.1 * before);
    EXPECT_EQ(s.stats.solid_unconverged, 0);
    // Only the rigid motion remains. Momenta stay to rounding, 1e-6 of the motion, in a hundred steps.
    EXPECT_LT((fixture::momentum(s.particles) - linear).norm(), 1e-5 * motion);
    EXPECT_LT((fixture::angular_momentum(s.particles) - angular).norm(), 1e-5 * angular.norm());
    EXPECT_LT(s.solids.stretch2, 1.01);
}

TEST(ImplicitSolids, KnowWhenOnlyRoundingIsLeft) {
    // In flight no force acts on a body. Steps this short turn the last bits of places into accelerations. The solver
    // stops even where no solution exists.
    scene::Scene scene = implicit_scene(1e5);
    scene.bodies = {fixture::body("block", fixture::shape_at({0.5, 0.2, 0}, scene::BoxShape{{0.1, 0.05, 0.06}, 0}),
                                  {1, -0.5, 0.3})};
    scene.bodies[0].angular_velocity = {5, 20, 10};
    Simulation s = make_simulation(scene);
    fixture::steps(s, 20, 1e-3);
    for (int k = 0; k < 20; ++k) fixture::steps(s, 1, 1e-5);
    EXPECT_EQ(s.stats.solid_unconverged, 0);
    EXPECT_EQ(s.stats.solid_sub_steps, 40);
}

TEST(ImplicitSolids, TheCoarseGridFindsTheSameInFewerIterations) {
    // A stiff beam, held at one end, bends under its weight. Both end within the tolerance, 1e-3 of the forces.
    const auto bent = [](bool two_levels, int& iterations) {
        scene::Scene scene = implicit_scene(1e9);
        scene.world.gravity = {0, 0, -9.81};
        scene.bodies = {fixture::body("beam", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.4, 0.06, 0.06}, 0}))};
        scene::Handle wall;
        wall.name = "wall";
        wall.body = "beam";
        wall.region = fixture::shape_at({-0.2, 0, 0}, scene::BoxShape{{0.03, 1, 1}, 0});
        scene.handles = {wall};
        Simulation s = make_simulation(scene);
        s.solid_scratch.implicit.two_levels = two_levels;
        double before = 0;
        for (const Vec3& x : s.particles.position) before += static_cast<double>(x.z());
        fixture::steps(s, 10, 0.002);
        EXPECT_EQ(s.stats.solid_unconverged, 0);
        iterations = s.stats.solid_iterations;
        double sum = 0;
        for (const Vec3& x : s.particles.position) sum += static_cast<double>(x.z());
        return sum - before;
    };
    int one = 0, two = 0;
    const double by_blocks = bent(false, one), by_both = bent(true, two);
    EXPECT_LT(by_blocks, 0);
    EXPECT_NEAR(by_both / by_blocks, 1, 0.02);
    EXPECT_LT(two, one / 4);
}

/// Two bodies fall onto each other and a floor. One of them deforms plastically and is held for a while.
scene::Scene two_busy_bodies() {
    scene::Scene s = implicit_scene(2e6);
    s.world.gravity = {0, 0, -9.81};
    s.world.boundaries = {fixture::floor_at(-0.031)};
    s.materials[0].elastic.creep = 20;
    s.materials[0].elastic.yield_strain = 0.001;
    s.materials[0].elastic.volume_stiffness = 1e6;
    s.bodies = {fixture::body("lower", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.1, 0.1, 0.06}, 0})),
                fixture::body("upper", fixture::shape_at({0.02, 0, 0.066}, scene::Sphere{0.035}), {0.3, 0.2, -1.5})};
    s.bodies[1].angular_velocity = {0, 20, 5};
    scene::Handle hand;
    hand.name = "hand";
    hand.body = "lower";
    hand.region = fixture::shape_at({-0.05, 0, 0}, scene::BoxShape{{0.03, 1, 1}, 0});
    hand.stop = 0.03;
    s.handles = {hand};
    s.frames.fps = 100;
    return s;
}

TEST(ImplicitSolids, StateIsTheSameAtAnyThreadCount) {
    fixture::expect_same_at_any_thread_count(two_busy_bodies(), [](Simulation& s) {
        std::size_t met = 0;
        for (int k = 0; k < 2; ++k) {
            advance_frame(s);
            met = std::max(met, s.solids.contacts.nodes.size());
        }
        EXPECT_GT(met, 20u);
    });
}

TEST(ImplicitSolids, ResumedRunEqualsTheUninterruptedOneBitForBit) {
    Simulation whole = make_simulation(two_busy_bodies());
    for (int k = 0; k < 2; ++k) advance_frame(whole);
    fixture::expect_resumes(whole, 2);
    Real dent = 0;
    for (const Symmetric& p : whole.solids.elements.plastic) dent = std::max(dent, norm(p));
    EXPECT_GT(dent, 1e-4);
    EXPECT_EQ(whole.stats.solid_unconverged, 0);
}

}  // namespace
}  // namespace thixo
