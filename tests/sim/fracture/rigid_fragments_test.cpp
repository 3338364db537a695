// Fragments that are too small to be elastic go on as rigid bodies.
#include "sim/fracture/rigid_fragments.h"

#include <gtest/gtest.h>

#include "pipeline/geometry/shapes.h"
#include "sim/solid/rigid_rates.h"
#include "sim/stage/checkpoint.h"
#include "tests/sim/identity.h"
#include "tests/sim/solid/rubber.h"

namespace thixo {
namespace {

using fixture::rubber_block_scene;

constexpr double kSpacing = 0.01;

/// Cuts the `count` elements off that are nearest to a corner of body 0, along a sphere. Returns the new body.
std::size_t break_off(Simulation& s, std::size_t count) {
    const Elements& e = s.solids.elements;
    const Vec3 corner(Real(0.06), Real(0.03), Real(0.03));
    std::vector<Real> distance;
    for (const Index i : s.solids.bodies[0].elements) distance.push_back((xyz(e.rest[i]) - corner).norm());
    std::ranges::sort(distance);
    const double radius = static_cast<double>(distance[count - 1] + distance[count]) / 2;
    return cut_body(0, translated(sphere(radius), corner.cast<double>()), matter_of(s));
}

/// The rigid motion that has a body's momenta, in the world.
RigidRates rates_of(const Simulation& s, std::size_t b) {
    const SolidBody& body = s.solids.bodies[b];
    return rigid_rates(body, s.solids.elements, [&](std::size_t k) {
        const Index p = s.solids.particle_of[body.elements[k]];
        const Vec3d v = s.particles.velocity[p].cast<double>();
        return std::pair(Vec3d(s.particles.position[p].cast<double>()),
                         Vec3d(static_cast<double>(s.particles.mass[p]) * v));
    });
}

double kinetic_energy(const Simulation& s, std::size_t b) {
    double sum = 0;
    for (const Index i : s.solids.bodies[b].elements) {
        const Index p = s.solids.particle_of[i];
        sum += 0.5 * static_cast<double>(s.particles.mass[p] * s.particles.velocity[p].squaredNorm());
    }
    return sum;
}

/// Gives a body this rigid motion in place of its own.
void set_motion(Simulation& s, std::size_t b, const Vec3d& velocity, const Vec3d& spin) {
    const SolidBody& body = s.solids.bodies[b];
    const Vec3d centre = rates_of(s, b).centre;
    for (const Index i : body.elements) {
        const Index p = s.solids.particle_of[i];
        const Vec3d v = velocity + spin.cross(s.particles.position[p].cast<double>() - centre);
        s.solids.elements.velocity[i] = quad((body.turn.transpose() * v).cast<Real>());
        s.particles.velocity[p] = v.cast<Real>();
    }
}

/// Distances between all pairs of a body's particles [m].
std::vector<double> distances(const Simulation& s, std::size_t b) {
    std::vector<double> all;
    const auto place = [&](Index i) { return s.particles.position[s.solids.particle_of[i]].cast<double>().eval(); };
    for (const Index i : s.solids.bodies[b].elements)
        for (const Index j : s.solids.bodies[b].elements) all.push_back((place(i) - place(j)).norm());
    return all;
}

/// A block of which a corner of `count` elements has broken off. The corner has flown away for 30 ms.
struct Parted {
    Simulation s;
    std::size_t corner;
};
Parted parted(scene::SolidSteps steps, std::size_t count, const Vec3d& velocity) {
    Parted p{make_simulation(rubber_block_scene(steps)), 0};
    fixture::steps(p.s, 2, 1e-3);
    p.corner = break_off(p.s, count);
    set_motion(p.s, p.corner, velocity, {0, 0, 0});
    fixture::steps(p.s, 30, 1e-3);
    return p;
}

class RigidFragments : public testing::TestWithParam<scene::SolidSteps> {};

TEST_P(RigidFragments, HaveTheMomentaThatTheirMatterHad) {
    scene::Scene scene = rubber_block_scene(GetParam());
    scene.bodies[0].velocity = {0.3, -0.2, 0.1};
    scene.bodies[0].angular_velocity = {2, 5, 1};
    Simulation s = make_simulation(scene);
    fixture::steps(s, 3, 1e-3);
    const Vec3d momentum = fixture::momentum(s.particles), angular = fixture::angular_momentum(s.particles);
    const std::size_t before = s.particles.size(), crumb = break_off(s, 1), piece = break_off(s, 6);
    EXPECT_TRUE(s.solids.bodies[crumb].rigid && s.solids.bodies[piece].rigid);
    EXPECT_FALSE(s.solids.bodies[0].rigid);
    EXPECT_EQ(s.solids.bodies[crumb].size(), 4u) << "a single element is split, so that it can turn";
    EXPECT_GT(s.particles.size(), before);
    // Sums of some 400 numbers in single precision.
    EXPECT_LT((fixture::momentum(s.particles) - momentum).norm(), 1e-6 * momentum.norm());
    EXPECT_LT((fixture::angular_momentum(s.particles) - angular).norm(), 1e-5 * angular.norm());
}

TEST_P(RigidFragments, KeepTheirShapeMomentaAndEnergyInFreeFlight) {
    auto [s, b] = parted(GetParam(), 6, {2, 1, 1});
    // About the axis of the middle moment of inertia, nearly: it turns over again and again.
    const Eigen::SelfAdjointEigenSolver<Mat3d> axes(rates_of(s, b).inertia);
    set_motion(s, b, {1, 0.5, 0.5}, 40 * (axes.eigenvectors().col(1) + 0.05 * axes.eigenvectors().col(0)));
    const RigidRates before = rates_of(s, b);
    const double energy = kinetic_energy(s, b);
    const std::vector<double> shape = distances(s, b);
    fixture::steps(s, 500, 1e-3);
    const RigidRates after = rates_of(s, b);
    // Rounding of 500 steps in single precision. Half-steps of velocities are of second order: (40/s 1 ms)^2.
    EXPECT_LT((after.velocity - before.velocity).norm(), 1e-5 * before.velocity.norm());
    EXPECT_LT((after.angular - before.angular).norm(), 2e-3 * before.angular.norm());
    EXPECT_NEAR(kinetic_energy(s, b), energy, 5e-3 * energy);
    EXPECT_LT((after.centre - before.centre - 0.5 * before.velocity).norm(), 1e-4);
    const std::vector<double> now = distances(s, b);
    ASSERT_EQ(now.size(), shape.size());
    // Places of single precision half a metre away.
    for (std::size_t k = 0; k < now.size(); ++k) EXPECT_NEAR(now[k], shape[k], 1e-5 * kSpacing);
}

TEST_P(RigidFragments, GiveTheBodyThatTheyHitWhatTheyLose) {
    auto [s, b] = parted(GetParam(), 1, {1, 0, 0});
    set_motion(s, b, {-1, 0, 0}, {0, 0, 0});
    const Vec3d momentum = fixture::momentum(s.particles), angular = fixture::angular_momentum(s.particles);
    const double lost = rates_of(s, b).mass, motion = fixture::motion(s.particles);
    fixture::steps(s, 100, 1e-3);
    const RigidRates after = rates_of(s, b);
    EXPECT_GT(after.velocity.x(), -0.9) << "it has met the block";
    EXPECT_LT((fixture::momentum(s.particles) - momentum).norm(), 1e-4 * motion);
    // Places of contact slide by at most a quarter of a width until nodes are found again (contact.h).
    EXPECT_LT((fixture::angular_momentum(s.particles) - angular).norm(),
              0.25 * kSpacing * lost * (after.velocity + Vec3d(1, 0, 0)).norm());
}

TEST_P(RigidFragments, AreTheSameAtAnyThreadCountAndAfterAResume) {
    fixture::expect_identity_after(rubber_block_scene(GetParam()), [](Simulation& s) {
        set_motion(s, break_off(s, 1), {-0.5, 0.1, 0}, {5, 10, 0});
    });
}

INSTANTIATE_TEST_SUITE_P(Steps, RigidFragments,
                         testing::Values(scene::SolidSteps::leapfrog, scene::SolidSteps::implicit_euler));

TEST(RigidFragments, ThatAreCutAgainCanTurnAsWell) {
    Simulation s = make_simulation(rubber_block_scene());
    fixture::steps(s, 2, 1e-3);
    const std::size_t piece = break_off(s, 6);
    const Vec3 first = xyz(s.solids.elements.rest[s.solids.bodies[piece].elements.front()]);
    const std::size_t crumb = split_body(
        piece, [&](const Vec3& m) { return (m - first).norm() < Real(1e-4); }, matter_of(s));
    EXPECT_TRUE(s.solids.bodies[piece].rigid && s.solids.bodies[crumb].rigid);
    const Eigen::SelfAdjointEigenSolver<Mat3d> inertia(rates_of(s, crumb).inertia);
    EXPECT_GT(inertia.eigenvalues()[0], 0.5 * inertia.eigenvalues()[2]);
}

TEST(RigidFragments, AreNoneOfWhatAHandleHoldsNowOrLater) {
    scene::Scene scene = rubber_block_scene();
    scene::Handle hand;
    hand.name = "hand";
    hand.body = "block";
    hand.region = fixture::shape_at({0.06, 0.03, 0.03}, scene::BoxShape{{0.03, 0.03, 0.03}, 0});
    hand.start = 100;
    scene.handles = {hand};
    Simulation s = make_simulation(scene);
    fixture::steps(s, 2, 1e-3);
    EXPECT_FALSE(s.solids.bodies[break_off(s, 1)].rigid);
}

TEST(RigidFragments, AreNoHalvesOfASheetOfOneLayer) {
    // No stencil in it spans space, but it is elastic in its plane.
    scene::Scene scene = rubber_block_scene();
    scene.bodies[0].shape = fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.12, 0.12, 0.01}, 0});
    Simulation s = make_simulation(scene);
    fixture::steps(s, 2, 1e-3);
    const std::size_t particles = s.particles.size();
    ASSERT_TRUE(std::ranges::none_of(s.solids.elements.bonds.moment, [](const RestMoment& m) { return m.full; }));
    const std::size_t half = cut_body(0, plane(Vec3d(1, 0, 0), 0), matter_of(s));
    EXPECT_FALSE(s.solids.bodies[0].rigid || s.solids.bodies[half].rigid);
    EXPECT_EQ(s.particles.size(), particles);
}

TEST(RigidFragments, OfOneElementHaveTheInertiaOfACube) {
    Simulation s = make_simulation(rubber_block_scene());
    fixture::steps(s, 2, 1e-3);
    const RigidRates r = rates_of(s, break_off(s, 1));
    const double width = std::cbrt(r.mass / 1000);
    const Mat3d cube = r.mass * width * width / 6 * Mat3d::Identity();
    EXPECT_LT((r.inertia - cube).norm(), 1e-3 * cube.norm());
}

/// A pebble of this radius [m] that is made rigid on a floor, and slides along x at a speed [m/s].
struct Pebble {
    Simulation s;
    double speed() const { return rates_of(s, 0).velocity.x(); }
    Vec3d spin() const { return rates_of(s, 0).spin; }
};
Pebble pebble(scene::SolidSteps steps, double radius, double friction, double speed) {
    scene::Scene scene = rubber_block_scene(steps);
    scene.surface.enabled = false;
    scene.world.gravity = {0, 0, -9.81};
    scene.world.boundaries = {fixture::floor_at(-radius)};
    scene.materials[0].elastic.friction = friction;
    scene.bodies = {fixture::body("pebble", fixture::shape_at({0, 0, 0}, scene::Sphere{radius}))};
    Pebble p{make_simulation(scene)};
    // A packing of one particle need not be in the middle. Here it is, so that the pebble rolls evenly.
    SolidBody& body = p.s.solids.bodies[0];
    EXPECT_EQ(body.size(), 1u);
    body.place.setZero();
    body.origin.setZero();
    const std::vector<std::uint8_t> all{1};
    EXPECT_EQ(make_rigid(all, matter_of(p.s)), all);
    bind_matter(all, matter_of(p.s));
    set_motion(p.s, 0, {speed, 0, 0}, {0, 0, 0});
    return p;
}

TEST_P(RigidFragments, SlideOnARoughFloorUntilTheyRoll) {
    constexpr double kSpeed = 0.3, kRadius = 0.006;
    Pebble p = pebble(GetParam(), kRadius, 0.8, kSpeed);
    const RigidRates r = rates_of(p.s, 0);
    // Friction keeps the angular momentum about the place of contact: m R v0 = (m R + I/R) v.
    const double rolling = kSpeed / (1 + r.inertia(1, 1) / (r.mass * kRadius * kRadius));
    // Sliding ends after (v0 - v)/(mu g), some 10 ms. Samples of surfaces are no spheres: rolling costs some speed.
    fixture::steps(p.s, 60, 1e-3);
    EXPECT_NEAR(p.speed(), rolling, 0.05 * rolling);
    EXPECT_NEAR(p.spin().y() * kRadius, p.speed(), 0.05 * rolling);
}

TEST_P(RigidFragments, SlideOnASmoothFloorForEver) {
    Pebble p = pebble(GetParam(), 0.006, 0, 0.3);
    fixture::steps(p.s, 60, 1e-3);
    EXPECT_NEAR(p.speed(), 0.3, 1e-4);
    // It bears its weight: it sinks by less than contact is foreseen from, a quarter of a width.
    EXPECT_NEAR(rates_of(p.s, 0).centre.z(), 0, 0.25 * kSpacing);
}

}  // namespace
}  // namespace thixo
