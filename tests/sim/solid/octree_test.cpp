// Solids sampled by an octree: elements of several sizes in one body.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/contract/scene_io.h"
#include "tests/sim/identity.h"
#include "tests/sim/solid/rubber.h"

namespace thixo {
namespace {

/// A ball of 24 spacings sampled by an octree, and a block beside it that is not.
scene::Scene ball_and_block() {
    scene::Scene s = fixture::rubber_scene();
    s.bodies = {fixture::body("ball", fixture::shape_at({0.2, 0, 0}, scene::Sphere{0.12}), {0.3, 0, 0}),
                fixture::body("block", fixture::shape_at({0.36, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}))};
    s.bodies[0].sampling = {scene::Lattice::octree, 2};
    s.bodies[0].surfels = 500;
    s.bodies[1].surfels = 200;
    s.surface.enabled = true;
    s.frames.fps = 100;
    return s;
}

TEST(OctreeSolid, HasTheMassOfItsShapeInElementsOfThreeSizes) {
    const Simulation s = make_simulation(ball_and_block());
    const Elements& e = s.solids.elements;
    const SolidBody& ball = s.solids.bodies[0];
    std::set<Real> supports;
    double mass = 0;
    for (const Index i : ball.elements) {
        supports.insert(e.support[i]);
        mass += static_cast<double>(e.mass[i]);
        EXPECT_GE(e.mass[i], e.mass[ball.lightest]);
        // Fluids and walls within reach of the surface meet the finest alone.
        if (e.depth[i] < Real(0.02)) {
            EXPECT_FLOAT_EQ(e.support[i], 0.02f);
        }
    }
    EXPECT_EQ(supports.size(), 3u);
    EXPECT_NEAR(mass, 1000 * 4 / 3.0 * kPi * cube(0.12), 2e-3 * mass);  // the volume of cut cells is found to that
    EXPECT_LT(static_cast<double>(ball.size()), 0.8 * 4 / 3.0 * kPi * cube(12));  // fewer than of one size
    EXPECT_FLOAT_EQ(e.support[ball.typical], 0.02f);
    EXPECT_NEAR(std::cbrt(e.volume[ball.typical]), 0.01, 5e-4);
}

TEST(OctreeSolid, PassesThePatchTest) {
    Simulation s = make_simulation(ball_and_block());
    fixture::steps(s, 1, 1e-6);  // sets up the laws
    Elements& e = s.solids.elements;
    const SolidBody& ball = s.solids.bodies[0];
    const Mat3 h = (Mat3() << 0.01f, 0.02f, -0.01f, 0.005f, -0.02f, 0.015f, 0.01f, -0.005f, 0.015f).finished();
    for (const Index i : ball.elements) e.displacement[i] = quad(h * xyz(e.rest[i]));
    for (const Index i : ball.elements) EXPECT_LT((gradient_of(e, i) - h).norm(), 2e-5f);
    refresh_surface(s);
    const Vec3 centre = ball.place.cast<Real>();
    for (std::size_t i = 0; i < 500; ++i) {
        ASSERT_EQ(s.embedded_source[i], i);
        const Vec3& m = s.embedded.rest.position[i];
        EXPECT_LT((s.surface.surfels.position[i] - centre - m - h * m).norm(), 1e-6f);
        EXPECT_LT((s.surface.surfels.axis1[i] - (Mat3::Identity() + h) * s.embedded.rest.axis1[i]).norm(), 1e-6f);
    }
    // A rotation causes no force.
    const Mat3 turn = Eigen::AngleAxis<Real>(Real(1.3), Vec3(0.3f, -0.8f, 0.52f).normalized()).toRotationMatrix();
    for (const Index i : ball.elements) {
        e.displacement[i] = quad((turn - Mat3::Identity()) * xyz(e.rest[i]));
        e.velocity[i] = quad(Vec3::Zero());
    }
    StressScratch scratch;
    std::vector<Vec3> force;
    find_stress_forces(s.solids.laws, e, scratch, force);
    for (const Index i : ball.elements)  // against those of 1 % strain on a cell's face
        EXPECT_LT(force[i].norm(), 0.02 * 1e5 * 0.01 * square(std::cbrt(e.volume[i])));
}

TEST(OctreeSolid, KeepsMomentumInACollision) {
    Simulation s = make_simulation(ball_and_block());
    const Vec3d linear = fixture::momentum(s.particles);
    const auto of_block = [&] {
        double sum = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            if (s.particles.body[i] == 1) sum += static_cast<double>(s.particles.mass[i] * s.particles.velocity[i].x());
        return sum;
    };
    for (int k = 0; k < 12; ++k) advance_frame(s);
    EXPECT_GT(of_block(), 0.2 * 0.3 * 0.216);  // it was hit: a part of its mass times the ball's speed
    EXPECT_LT((fixture::momentum(s.particles) - linear).norm(), 1e-5 * linear.norm());
}

TEST(OctreeSolid, StateIsTheSameAtAnyThreadCount) {
    fixture::expect_same_at_any_thread_count(ball_and_block(), [](Simulation& s) {
        refresh_surface(s);
        for (int k = 0; k < 4; ++k) advance_frame(s);
    });
}

TEST(OctreeSolid, ResumedRunEqualsTheUninterruptedOneBitForBit) {
    Simulation whole = make_simulation(ball_and_block());
    refresh_surface(whole);
    for (int k = 0; k < 2; ++k) advance_frame(whole);
    fixture::expect_resumes(whole, 2);
}

TEST(OctreeSolid, IsRefusedWhereParticlesOfSeveralSizesCannotBe) {
    const auto refusal = [](const std::string& materials, const std::string& lattice, const std::string& more = "") {
        try {
            scene::parse_scene("frames: {first: 0, last: 1}\nmaterials: {stuff: {" + materials +
                                   "}, water: {}}\nbodies: {thing: {material: stuff, sampling: {lattice: " + lattice +
                                   "}, shape: {sphere: {radius: 0.1}}}}\n" + more,
                               "octree.yaml");
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    const std::string rubber = "youngs_modulus: 1.0e5", melting = rubber + ", melting: {from: 0, to: 10}",
                      tap = "emitters: {tap: {material: water, position: [0, 0, 1]}}\n";
    EXPECT_EQ(refusal(rubber, "octree"), "");
    EXPECT_EQ(refusal(rubber, "uniform", tap), "");
    for (const std::string& said : {refusal("viscosity: 1", "octree"), refusal(melting, "uniform")})
        EXPECT_NE(said.find("octree.yaml:3:"), std::string::npos) << said;
    EXPECT_NE(refusal(rubber, "octree", tap).find("with liquids"), std::string::npos);
    EXPECT_NE(refusal(rubber + ", conductivity: 1", "octree").find("heat in a solid"), std::string::npos);
    EXPECT_NE(refusal(rubber, "hexagon").find("hexagonal"), std::string::npos);
}

}  // namespace
}  // namespace thixo
