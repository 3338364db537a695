// Matter that melts, freezes and breaks.
#include "sim/fracture/frozen.h"

#include <gtest/gtest.h>

#include <set>

#include "pipeline/geometry/shapes.h"
#include "sim/bonds/rest_shape.h"
#include "sim/stage/checkpoint.h"
#include "tests/sim/heat/heat_of.h"
#include "tests/sim/identity.h"
#include "tests/sim/phase/wax.h"

namespace thixo {
namespace {

using namespace fixture::melting;

/// The part of the block on the +x side, which `cut_body` cuts off.
Shape right_half() { return plane(Vec3d(-1, 0, 0), 0); }
Shape a_corner() { return translated(sphere(0.012), Vec3d(0.03, 0.03, 0.061)); }

/// A crack across the top of the block, 1 cm deep: its front is there from the start.
scene::PaintedCrack scratch() {
    return {.points = {{.at = {-0.02, -0.03, 0.061}}, {.at = {-0.02, 0.03, 0.061}}}, .image = {}, .depth = 0.01};
}

/// A block of wax, 6 x 6 x 6 cm, on a floor. It breaks at this tension [Pa].
scene::Scene brittle_wax(double strength) {
    scene::Scene scene = fixture::empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.world.boundaries = {fixture::floor_at(0)};
    scene.surface.enabled = true;
    scene.materials = {wax()};
    scene.materials[0].elastic.youngs_modulus = 1e6;
    scene.materials[0].melting.liquid.viscosity = 40;
    scene.materials[0].fracture.strength = strength;
    scene.bodies = {of(fixture::body("block", box({0, 0, 0.031}, {0.06, 0.06, 0.06})), "wax", 30)};
    return scene;
}

void go_on(Simulation& s, int frames) {
    for (int k = 0; k < frames; ++k) advance_frame(s);
}

std::size_t bodies_with_matter(const Simulation& s) {
    return static_cast<std::size_t>(
        std::ranges::count_if(s.solids.bodies, [](const SolidBody& b) { return !b.empty(); }));
}

/// Melts the upper part of the block, freezes it in the shape that it then has, and lets it come to rest.
void melt_and_freeze(Simulation& s) {
    go_on(s, 1);
    set_temperature(s, [](const Vec3& x) { return x.z() > 0.02f ? 70.0 : 30.0; });
    go_on(s, 3);
    set_temperature(s, [](const Vec3&) { return 20; });
    go_on(s, 6);
}

void throw_down(Simulation& s, double speed) {
    SolidBody& body = s.solids.bodies[0];
    body.place += Vec3d(0, 0, 0.05);
    for (const Index i : body.elements) {
        s.particles.position[s.solids.particle_of[i]] += Vec3(0, 0, Real(0.05));
        s.solids.elements.velocity[i] = quad((body.turn.transpose() * Vec3d(0, 0, -speed)).cast<Real>());
    }
}

TEST(Frozen, MatterHasTheSurfaceAndTheCracksOfASolid) {
    Simulation s = make_simulation(brittle_wax(4e3));
    const double mass = [&] {
        double sum = 0;
        for (const Real m : s.particles.mass) sum += static_cast<double>(m);
        return sum;
    }();
    melt_and_freeze(s);
    ASSERT_EQ(s.solids.bodies.size(), 1u);
    EXPECT_EQ(s.solids.bodies[0].skin, Skin::embedded);
    EXPECT_NE(s.solids.bodies[0].frame, s.solids.bodies[0].source);
    EXPECT_EQ(s.mixed_surface.animated.size(), 0u);
    EXPECT_EQ(s.mixed_surface.refrozen.size(), 0u);
    EXPECT_GT(s.embedded.size(), 300u);
    EXPECT_FALSE(s.solids.cracks.any()) << "it lies there";
    // A block of 1 MPa that stops from 3 m/s is loaded with some sqrt(E rho) v = 95 kPa.
    throw_down(s, 3);
    go_on(s, 4);
    EXPECT_TRUE(s.solids.cracks.any());
    EXPECT_GE(bodies_with_matter(s), 2u);
    for (const Crack& crack : s.solids.cracks.cracks) EXPECT_EQ(crack.frame, s.solids.bodies[0].frame);
    // Stencils beside cracks leave out the same flat directions as all others of matter that has flowed.
    Elements measured = s.solids.elements;
    measure_moments(measured, nullptr, kThin);
    for (std::size_t i = 0; i < measured.size(); ++i)
        EXPECT_EQ(s.solids.elements.bonds.moment[i].full, measured.bonds.moment[i].full) << i;
    double now = 0;
    for (const Real m : s.particles.mass) now += static_cast<double>(m);
    EXPECT_NEAR(now, mass, 1e-6 * mass);
    std::vector<std::int64_t> ids = s.surface.id;
    std::ranges::sort(ids);
    EXPECT_EQ(std::ranges::adjacent_find(ids), ids.end()) << "ids of surfels are unique";
}

TEST(Frozen, MatterThatBreaksGoesOnAlikeAfterAResume) {
    const scene::Scene scene = brittle_wax(4e3);
    Simulation whole = make_simulation(scene);
    melt_and_freeze(whole);
    throw_down(whole, 3);
    fixture::expect_resumes(whole, 1);  // before it breaks
    go_on(whole, 1);
    fixture::expect_resumes(whole, 2);  // in pieces
    set_temperature(whole, [](const Vec3& x) { return x.x() > 0 ? 70.0 : 20.0; });
    go_on(whole, 1);
    fixture::expect_resumes(whole, 2);  // in pieces, some of which melt
}

TEST(Frozen, PiecesThatMeltAreOneBodyAgainAndFreezeWhole) {
    Simulation s = make_simulation(brittle_wax(1e7));
    go_on(s, 1);
    const std::size_t part = cut_body(0, right_half(), matter_of(s));
    const std::vector<Index> cut_off = s.solids.bodies[part].elements;
    go_on(s, 1);
    ASSERT_EQ(bodies_with_matter(s), 2u);
    set_temperature(s, [](const Vec3&) { return 70; });
    go_on(s, 4);
    EXPECT_EQ(bodies_with_matter(s), 1u);
    EXPECT_TRUE(std::ranges::all_of(s.particles.body, [&](std::int32_t id) { return id == s.solids.bodies[0].id; }));
    for (const std::int32_t id : s.surface.body) ASSERT_EQ(id, s.solids.bodies[0].id);
    set_temperature(s, [](const Vec3&) { return 20; });
    go_on(s, 6);
    EXPECT_EQ(bodies_with_matter(s), 1u);
    EXPECT_EQ(s.solids.bodies[0].skin, Skin::embedded);
    // Bonds join what had been cut: both halves have flowed together.
    std::size_t across = 0;
    const Bonds& bonds = s.solids.elements.bonds;
    for (const Index i : cut_off)
        for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k)
            across += bonds.weight[k] > 0 && !std::ranges::binary_search(cut_off, bonds.neighbour[k]);
    EXPECT_GT(across, cut_off.size());
    EXPECT_FALSE(has_come_apart(s.solids.bodies[0], s.solids.elements));
}

TEST(Frozen, RigidPiecesThatMeltAreLiquidAgain) {
    Simulation s = make_simulation(brittle_wax(1e7));
    go_on(s, 1);
    const std::size_t part = cut_body(0, a_corner(), matter_of(s));
    ASSERT_TRUE(s.solids.bodies[part].rigid);
    go_on(s, 1);
    set_temperature(s, [](const Vec3&) { return 70; });
    go_on(s, 4);
    EXPECT_FALSE(s.solids.bodies[part].rigid);
    EXPECT_EQ(bodies_with_matter(s), 1u);
    for (const Real q : s.solids.elements.quadrature) EXPECT_GT(q, 0);
}

TEST(Frozen, ACrumbThatMeltsBesideAColdBodyStaysItsOwn) {
    scene::Scene scene = brittle_wax(1e7);
    scene.bodies[0].cracks = {scratch()};
    Simulation s = make_simulation(scene);
    go_on(s, 1);
    const std::size_t part = cut_body(0, a_corner(), matter_of(s));
    const std::int32_t id = s.solids.bodies[part].id;
    go_on(s, 1);
    ASSERT_FALSE(s.solids.cracks.fronts.empty());
    std::set<std::int64_t> crumb;
    for (const Index i : s.solids.bodies[part].elements) crumb.insert(s.solids.elements.id[i]);
    for (Index k = 0; k < s.particles.size(); ++k)
        if (crumb.contains(s.particles.id[k])) s.particles.temperature[k] = 70;
    go_on(s, 3);
    EXPECT_EQ(s.solids.bodies[part].size(), crumb.size());
    EXPECT_EQ(s.solids.bodies[part].id, id);
    EXPECT_EQ(s.solids.bodies[0].skin, Skin::embedded) << "the cold body is what it was";
    EXPECT_FALSE(s.solids.cracks.fronts.empty()) << "and its crack goes on";
}

TEST(Frozen, DropsThatFreezeApartAreBodiesOfTheirOwn) {
    // One body melts and flows into two heaps. Frozen, it has come apart, in a frame without cracks beside one that has some.
    scene::Scene scene = brittle_wax(1e7);
    scene.bodies[0].cracks = {scratch()};
    Simulation s = make_simulation(scene);
    go_on(s, 1);
    set_temperature(s, [](const Vec3&) { return 70; });
    go_on(s, 1);
    for (Index k = 0; k < s.particles.size(); ++k)
        if (s.particles.position[k].x() > 0) s.particles.position[k].x() += Real(0.08);
    go_on(s, 1);
    set_temperature(s, [](const Vec3&) { return 20; });
    go_on(s, 8);
    EXPECT_EQ(bodies_with_matter(s), 2u);
    for (const SolidBody& body : s.solids.bodies) EXPECT_FALSE(has_come_apart(body, s.solids.elements));
}

TEST(Frozen, WhatHasOnlySoftenedBreaksAgain) {
    Simulation s = make_simulation(brittle_wax(4e3));
    go_on(s, 1);
    set_temperature(s, [](const Vec3& x) { return x.z() > 0.04f ? 45.0 : 30.0; });
    go_on(s, 1);
    ASSERT_EQ(s.solids.bodies[0].skin, Skin::animated);
    set_temperature(s, [](const Vec3&) { return 20; });
    go_on(s, 3);
    EXPECT_EQ(s.solids.bodies[0].skin, Skin::embedded);
    EXPECT_FALSE(s.solids.bodies[0].refrozen);
    EXPECT_LT(s.solids.elements.strength[s.solids.bodies[0].typical], kUnbreakable);
}

TEST(Frozen, IdsOfSurfelsAreUniqueAndNeverGivenAgain) {
    // Both bodies have surfels of a cut. Each time that one freezes, its old ones are dropped, and it gets new ones.
    scene::Scene scene = brittle_wax(1e7);
    scene.bodies.push_back(scene.bodies[0]);
    scene.bodies[1].name = "other";
    scene.bodies[1].shape.translate = {0.2, 0, 0.031};
    Simulation s = make_simulation(scene);
    go_on(s, 1);
    cut_body(0, right_half(), matter_of(s));
    cut_body(1, plane(Vec3d(-1, 0, 0), -0.2), matter_of(s));
    go_on(s, 1);
    std::set<std::int64_t> before(s.surface.id.begin(), s.surface.id.end());
    for (int k = 0; k < 2; ++k) {
        set_temperature(s, [](const Vec3& x) { return x.x() < 0.1f ? 70.0 : 20.0; });
        go_on(s, 3);
        set_temperature(s, [](const Vec3&) { return 20; });
        go_on(s, 5);
        ASSERT_EQ(s.solids.bodies[0].skin, Skin::embedded);
        std::set<std::int64_t> now;
        for (std::size_t i = 0; i < s.surface.size(); ++i) {
            EXPECT_TRUE(now.insert(s.surface.id[i]).second) << s.surface.id[i];
            EXPECT_FALSE(s.surface.body[i] == s.solids.bodies[0].id && before.contains(s.surface.id[i]));
        }
        before.insert(now.begin(), now.end());
    }
}

}  // namespace
}  // namespace thixo
