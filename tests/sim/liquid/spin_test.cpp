// Shifts of places take no angular momentum from free liquids, and nothing turns where there is no centre.
#include "sim/liquid/spin.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

Vec3d spin_of(const Particles& p, const std::vector<Vec3>& shift) {
    Vec3d sum = Vec3d::Zero();
    for (std::size_t i = 0; i < p.size(); ++i) {
        const Vec3d x = (p.position[i] + shift[i]).cast<double>();
        sum += static_cast<double>(p.mass[i]) * x.cross(p.velocity[i].cast<double>());
    }
    return sum;
}

/// A ball of water that spins and tumbles, and shifts of a hundredth of a spacing at random.
struct ShiftedBall {
    ShiftedBall() : sim(make_simulation(scene_of())), walls(sim.particles.size()), shift(sim.particles.size()) {
        for (std::size_t i = 0; i < sim.particles.size(); ++i)
            for (int a = 0; a < 3; ++a) shift[i][a] = Real(1e-4 * (random_unit(1, i, 0, a) - 0.5));
    }
    static scene::Scene scene_of() {
        scene::Scene s = fixture::empty_space();
        s.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0}, scene::Sphere{0.05}), {1, 2, 3})};
        s.bodies[0].angular_velocity = {3, -2, 10};
        return s;
    }
    Simulation sim;
    std::vector<WallEffect> walls;
    std::vector<Vec3> shift;
};

TEST(Spin, OfAFreeLiquidStaysWhenItsPlacesAreShifted) {
    ShiftedBall b;
    Particles& p = b.sim.particles;
    const std::vector<Vec3> none(p.size(), Vec3::Zero());
    const Vec3d spin = spin_of(p, none), momentum = fixture::momentum(p);
    EXPECT_GT((spin_of(p, b.shift) - spin).norm(), 1e-6 * spin.norm());  // there is something to turn back
    keep_spin(b.walls, b.shift, p);
    // Velocities are rounded to 6e-8 of themselves.
    EXPECT_LT((spin_of(p, b.shift) - spin).norm(), 1e-7 * fixture::motion(p) * 0.05);
    EXPECT_LT((fixture::momentum(p) - momentum).norm(), 1e-7 * fixture::motion(p));
}

TEST(Spin, OfALiquidAtAWallIsTheWalls) {
    ShiftedBall b;
    b.walls[3].share = Real(0.1);
    const std::vector<Vec3> before = b.sim.particles.velocity;
    keep_spin(b.walls, b.shift, b.sim.particles);
    EXPECT_TRUE(before == b.sim.particles.velocity);
}

TEST(Spin, NothingTurnsThatLeavesThroughAPeriodicFace) {
    // A ball of water that flies through the face, half here and half there: it moves as it did, to rounding.
    scene::Scene scene = fixture::empty_space();
    scene.world.periodic = {{scene::Axis::x, -0.1, 0.1}};
    scene.solver.pressure = scene::Pressure::dfsph;
    scene.bodies = {fixture::body("ball", fixture::shape_at({0.03, 0.02, 0}, scene::Sphere{0.04}), {1, 0.5, 0})};
    Simulation s = make_simulation(scene);
    for (int k = 0; k < 2; ++k) advance_frame(s);
    std::size_t left = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        if (s.particles.position[i].x() < 0) ++left;
        // The packing relaxes by a hundredth of the speed; a turn about a middle between the halves would be a tenth.
        EXPECT_LT((s.particles.velocity[i] - Vec3(1, 0.5, 0)).norm(), 0.02);
    }
    EXPECT_GT(left, s.particles.size() / 10);
    EXPECT_LT(left, s.particles.size());
    const Vec3d momentum = fixture::momentum(s.particles);
    EXPECT_LT((momentum / momentum.x() - Vec3d(1, 0.5, 0)).norm(), 1e-5);
}

}  // namespace
}  // namespace thixo
