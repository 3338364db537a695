#include "sim/space/periodic.h"

#include <gtest/gtest.h>

#include <functional>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "sim/liquid/density.h"
#include "sim/liquid/forces.h"
#include "sim/stage/checkpoint.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

// A box without walls, periodic along the named axes, filled with water 1 cm apart.
scene::Scene periodic_box(const Vec3d& size, std::initializer_list<scene::Axis> axes) {
    scene::Scene s = fixture::empty_space();
    for (const scene::Axis a : axes) {
        const double half = size[static_cast<int>(a)] / 2;
        s.world.periodic.push_back({a, -half, half});
    }
    s.bodies = {fixture::body("water", fixture::shape_at({0, 0, 0}, scene::BoxShape{size, 0}))};
    return s;
}

scene::Scene periodic_cube(double edge = 0.128) {
    return periodic_box({edge, edge, edge}, {scene::Axis::x, scene::Axis::y, scene::Axis::z});
}

// The values in the order of ids, whatever the order in memory.
std::vector<Index> by_id(const Particles& p) {
    std::vector<Index> order(p.size());
    for (std::size_t i = 0; i < p.size(); ++i) order[static_cast<std::size_t>(p.id[i])] = static_cast<Index>(i);
    return order;
}

TEST(Periodic, AFilledBlockHasTheSameDensityEverywhere) {
    Simulation s = make_simulation(periodic_cube());
    evaluate(s);
    const auto [least, most] = std::minmax_element(s.particles.density.begin(), s.particles.density.end());
    // Every site of the packing sees the same sites. Places are rounded to 1.5e-8 m, a few 1e-6 of the spacing, in some
    // 40 terms.
    EXPECT_LT(*most - *least, 1e-5 * 1000);
    // The packing is stretched to fit by up to 4 % along each axis; masses follow, the sum to its quadrature error.
    EXPECT_NEAR(*least, 1000, 5);
}

TEST(Periodic, APairAcrossAFaceFeelsEqualAndOppositeForcesThoseOfAnyPair) {
    scene::Scene scene = periodic_cube();
    scene.materials[0].viscosity = 1;
    scene.bodies.clear();
    Simulation s = make_simulation(scene);
    Particles& p = s.particles;
    for (std::int64_t id = 0; id < 2; ++id) {
        const Index i = append_row(p);
        p.id[i] = id;
        p.melt[i] = 1;
        p.mass[i] = Real(1e-3);
        p.rest_volume[i] = Real(1e-6);
    }
    p.velocity[0] = Vec3(Real(0.3), Real(0.1), 0);
    // Two close particles: in the middle, across one face, across a corner.
    const Real half = Real(0.064);
    std::array<Vec3, 2> in_the_middle{};
    for (const Vec3& place : {Vec3(0, 0, 0), Vec3(half, 0, 0), Vec3(half, half, half)}) {
        const Vec3 apart(Real(0.004), Real(0.001), Real(0.002));
        p.position[0] = s.problem.periodic.wrapped(place - apart);
        p.position[1] = s.problem.periodic.wrapped(place + apart);
        evaluate(s);
        for (std::size_t i = 0; i < 2; ++i) {  // a pair alone is never dense enough to push
            s.sweep.place[i].w = 1000;
            s.sweep.motion[i].w = p.rest_volume[0];
        }
        refresh_places(s.sweep.ghosts, s.sweep.place);
        refresh_ghosts(s.sweep.ghosts, s.sweep.motion);
        compute_accelerations(p, s.neighbours, s.problem.smoothing, {Vec3::Zero(), Real(0.1)}, s.sweep);
        const std::vector<Index> order = by_id(p);
        const Vec3 a = p.acceleration[order[0]], b = p.acceleration[order[1]];
        EXPECT_GT(a.norm(), 1);
        EXPECT_EQ(a, -b);  // exactly: all differences are
        if (place.isZero()) in_the_middle = {a, b};
        EXPECT_EQ(a, in_the_middle[0]);
        if (order[0] != 0) reorder_table(p, order, s.reorder_scratch);
    }
}

void stir(Simulation& s, double speed) {
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        for (int a = 0; a < 3; ++a)
            s.particles.velocity[i][a] =
                static_cast<Real>(speed * (2 * random_unit(7, static_cast<std::uint64_t>(s.particles.id[i]), 0,
                                                           static_cast<std::uint64_t>(a)) -
                                           1));
}

TEST(Periodic, MomentumIsConservedAcrossFaces) {
    scene::Scene scene = periodic_cube(0.064);
    scene.materials[0].viscosity = 0.5;
    Simulation s = make_simulation(scene);
    stir(s, 0.5);
    for (Vec3& v : s.particles.velocity) v.x() += Real(0.5);  // many cross a face
    const Vec3d before = fixture::momentum(s.particles);
    const double scale = fixture::motion(s.particles);
    fixture::steps(s, 500, 1e-4);
    // As without periodic axes: each step rounds velocities by 6e-8 of them, to either side.
    EXPECT_LT((fixture::momentum(s.particles) - before).norm(), 1e-6 * scale);
    for (const Vec3& x : s.particles.position) EXPECT_LE(x.cwiseAbs().maxCoeff(), Real(0.032));
}

// Velocities over the speed of sound after some steps, by id, of a wave that stands `shift` along x; all particles are
// shifted with it.
std::vector<Vec3> wave(const std::function<Vec3(double phase)>& velocity, double shift) {
    constexpr double kEdge = 0.128;
    scene::Scene scene = periodic_cube(kEdge);
    scene.materials[0].viscosity = 0.1;
    Simulation s = make_simulation(scene);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const double x = s.particles.position[i].x();
        s.particles.velocity[i] = velocity(2 * kPi * x / kEdge);
        s.particles.position[i].x() += static_cast<Real>(shift);
    }
    wrap_particles(s.problem.periodic, s.particles);
    fixture::steps(s, 200, 5e-5);
    std::vector<Vec3> v;
    for (const Index i : by_id(s.particles)) v.push_back(s.particles.velocity[i] / s.problem.materials[0].sound_speed);
    return v;
}

void expect_shift_changes_nothing(const std::function<Vec3(double phase)>& velocity) {
    const std::vector<Vec3> here = wave(velocity, 0), there = wave(velocity, 0.064);
    Real largest = 0, worst = 0;
    for (std::size_t i = 0; i < here.size(); ++i) {
        largest = std::max(largest, here[i].norm());
        worst = std::max(worst, (here[i] - there[i]).norm());
    }
    // Half a period is a multiple of the grain. Differences have the same bits, but sums run in another order. That
    // changes a density by a few 1e-7, and so the pressure by as many rho c^2. This pressure acts in each of 200 steps,
    // in which sound moves by a tenth of a millimetre.
    EXPECT_LT(worst, 1e-5);
    EXPECT_GT(largest, 0.02);
}

TEST(Periodic, AShearWaveAcrossAFaceIsTheOneInTheMiddle) {
    expect_shift_changes_nothing([](double phase) { return Vec3(0, static_cast<Real>(0.05 * std::sin(phase)), 0); });
}

TEST(Periodic, ASoundWaveAcrossAFaceIsTheOneInTheMiddle) {
    expect_shift_changes_nothing([](double phase) { return Vec3(static_cast<Real>(0.05 * std::sin(phase)), 0, 0); });
}

TEST(Periodic, WithWallsAcrossTheOtherAxesNothingIsLost) {
    scene::Scene scene = periodic_box({0.08, 0.08, 0.06}, {scene::Axis::x});
    scene.world.gravity = {2, 0, -9.81};
    scene::Boundary room;
    room.name = "channel";
    room.inside = true;
    room.shape = fixture::shape_at({0, 0, 0.02}, scene::BoxShape{{1, 0.08, 0.1}, 0});
    scene.world.boundaries = {room};
    Simulation s = make_simulation(scene);
    const std::size_t count = s.particles.size();
    fixture::steps(s, 300, 2e-4);
    EXPECT_EQ(s.particles.size(), count);
    // The slope drives everything along x at the same pace: v = g t, whichever face was crossed.
    Vec3d p = fixture::momentum(s.particles);
    double mass = 0;
    for (const Real m : s.particles.mass) mass += static_cast<double>(m);
    EXPECT_NEAR(p.x() / mass, 2 * (300 - 0.5) * 2e-4, 1e-4);
    for (const Vec3& x : s.particles.position) {
        EXPECT_GE(x.x(), Real(-0.04));
        EXPECT_LT(x.x(), Real(0.04));
    }
}

TEST(Periodic, ThreadsAndCheckpointsChangeNoBit) {
    const auto run = [](bool interrupt) {
        Simulation s = make_simulation(periodic_cube(0.064));
        stir(s, 0.5);
        fixture::steps(s, 40, 1e-4);
        if (interrupt) {
            const std::string stored = print_checkpoint(s, "hash");
            Simulation again = make_simulation(periodic_cube(0.064));
            parse_checkpoint(stored, "memory", "hash", again);
            fixture::steps(again, 40, 1e-4);
            return print_checkpoint(again, "hash");
        }
        fixture::steps(s, 40, 1e-4);
        return print_checkpoint(s, "hash");
    };
    set_thread_count(1);
    const std::string one = run(false);
    set_thread_count(3);
    EXPECT_EQ(run(false), one);
    EXPECT_EQ(run(true), one);
    set_thread_count(0);
}

TEST(Periodic, WrappingIsExact) {
    const Periodic periodic = make_periodic(periodic_cube().world, Real(0.02));
    for (int k = -5; k <= 5; ++k) {
        const Vec3 x = periodic.wrapped(Vec3(Real(0.01234), Real(-0.05), Real(0.063)));
        const Vec3 shifted = periodic.wrapped(x + static_cast<Real>(k) * Vec3::Constant(periodic.period(0)));
        EXPECT_LT((shifted - x).norm(), 1e-6 * 0.128);
        EXPECT_EQ(periodic.wrapped(shifted), shifted);
    }
    const Real nan = std::numeric_limits<Real>::quiet_NaN();
    EXPECT_TRUE(std::isnan(periodic.wrapped(Vec3(nan, 0, 0)).x()));
}

TEST(Periodic, ABodyBeyondAFaceIsRefused) {
    scene::Scene scene = periodic_cube();
    scene.bodies[0].shape.translate = {0.02, 0, 0};
    EXPECT_THROW(make_simulation(scene), InputError);
}

}  // namespace
}  // namespace thixo
