// Cracks that bodies have from the start.
#include "sim/fracture/painted.h"

#include <gtest/gtest.h>

#include <array>

#include "pipeline/base/error.h"
#include "sim/fracture/tension.h"
#include "tests/sim/fracture/bars.h"
#include "tests/sim/identity.h"

namespace thixo {
namespace {

constexpr double kSpacing = 0.006;

scene::PaintedCrack along(std::initializer_list<Vec3d> points, double depth, double strength = 1) {
    scene::PaintedCrack crack{.points = {}, .depth = depth, .strength = strength};
    for (const Vec3d& at : points) crack.points.push_back({at});
    return crack;
}

constexpr double kStrength = 8e3;  // Pa

scene::Scene bar(const scene::PaintedCrack& crack) {
    scene::Scene s = fixture::breakable_bar(kStrength);
    s.surface.enabled = true;
    s.bodies[0].cracks = {crack};
    return s;
}

scene::Scene pulled_bar(const scene::PaintedCrack& crack) {
    scene::Scene s = bar(crack);
    fixture::draw_ends_apart(s);
    return s;
}

using fixture::pull;

using fixture::area_of;

TEST(PaintedCracks, HideOneSideFromTheOtherDownToTheirDepth) {
    // A cut 1 cm deep across the top of the bar. It is opaque within a tenth of a support behind its front.
    scene::Scene scene = bar(along({{0.01, -0.015, 0.015}, {0.01, 0.015, 0.015}}, 0.01));
    scene.materials[0].fracture.opacity = 0.2;
    const Simulation s = make_simulation(scene);
    const Elements& e = s.solids.elements;
    const Breaking& breaking = s.solids.breaking[0];
    const double bottom = 0.005;
    std::size_t cut = 0, whole = 0;
    for (Index i = 0; i < e.size(); ++i)
        for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
            const Vec3d from = (xyz(e.rest[i]) + breaking.origin).cast<double>(),
                        to = (xyz(e.rest[e.bonds.neighbour[k]]) + breaking.origin).cast<double>();
            const double part = (0.01 - from.x()) / (to.x() - from.x());
            if (!(part > 0 && part < 1)) continue;
            const double z = from.z() + part * (to.z() - from.z());
            if (z > bottom + static_cast<double>(breaking.opaque + breaking.row)) {
                EXPECT_EQ(e.bonds.visibility[k], 0) << "at " << z;
                ++cut;
            } else if (z < bottom - 1e-5) {
                EXPECT_EQ(e.bonds.visibility[k], 1) << "at " << z;
                ++whole;
            }
        }
    EXPECT_GT(cut, 50u);
    EXPECT_GT(whole, 50u);
    // The sheet is as large as the cut. It stands out of the body by a third of a row on three sides. Its ends taper over
    // a row each: a tenth of the cut.
    const double out = 0.3 * static_cast<double>(breaking.row);
    EXPECT_GT(area_of(s.solids.cracks), 0.9 * 0.03 * 0.01);
    EXPECT_LT(area_of(s.solids.cracks), (0.03 + 2 * out) * (0.01 + out));
    // Both faces have surfels of their own sheets.
    std::array<std::size_t, 2> faces{};
    for (const std::int32_t sheet : s.embedded.sheet)
        if (sheet >= kFirstCrackSheet) ++faces.at(static_cast<std::size_t>(sheet - kFirstCrackSheet));
    EXPECT_GT(faces[0], 20u);
    EXPECT_EQ(faces[0], faces[1]);
}

TEST(PaintedCracks, PartTheBodyAlongTheirLine) {
    // A slanting line across a bar of one strength: the crack runs down from it, within two spacings of its plane.
    Simulation s = make_simulation(pulled_bar(along({{-0.006, -0.015, 0.015}, {0.006, 0.015, 0.015}}, 0.006)));
    pull(s, 0.6);
    ASSERT_EQ(s.solids.bodies.size(), 2u);
    const Cracks& cracks = s.solids.cracks;
    const Vec3d across = Vec3d(0.03, -0.012, 0).normalized();
    const CrackTriangles& t = cracks.triangles;
    for (std::size_t k = 0; k < t.size(); ++k)
        if (t.crack[k] == 0)
            EXPECT_LT(std::abs(across.dot((cracks.vertex[t.a[k]] + s.solids.breaking[0].origin).cast<double>())),
                      2 * kSpacing);
    for (const SolidBody& body : s.solids.bodies) EXPECT_GT(body.size(), s.particles.size() / 3);
}

TEST(PaintedCracks, RunSoonerWhereTheyAreWeaker) {
    double parted[2];
    for (const double strength : {0.2, 1.0}) {
        Simulation s = make_simulation(pulled_bar(along({{0, -0.015, 0.015}, {0, 0.015, 0.015}}, 0.006, strength)));
        pull(s, 0.6);
        ASSERT_EQ(s.solids.bodies.size(), 2u) << strength;
        parted[strength < 1 ? 0 : 1] = s.clock.time;
    }
    EXPECT_LT(parted[0], 0.8 * parted[1]);
}

/// A ball of 3 cm with a ring around its middle.
scene::Scene ringed_ball(double depth) {
    scene::Scene s = fixture::breakable_bar(kStrength);
    s.surface.enabled = true;
    s.bodies = {fixture::body("ball", fixture::shape_at({0, 0, 0}, scene::Sphere{0.03}))};
    scene::PaintedCrack ring{.points = {}, .depth = depth};
    constexpr int kPoints = 24;
    for (int k = 0; k < kPoints; ++k) {
        const double angle = 2 * kPi * k / kPoints;
        ring.points.push_back({{0.03 * std::cos(angle), 0.03 * std::sin(angle), 0.001}});
    }
    ring.points.push_back(ring.points.front());
    s.bodies[0].cracks = {ring};
    return s;
}

TEST(PaintedCracks, OfARingHaveAClosedFront) {
    const Simulation s = make_simulation(ringed_ball(0.012));
    ASSERT_EQ(s.solids.cracks.fronts.size(), 1u);
    const CrackFront& front = s.solids.cracks.fronts[0];
    EXPECT_EQ(front.closed, 1);
    const double row = s.solids.breaking[0].row;
    for (const CrackNode& node : front.nodes) {
        const Vec3d at = (node.place + s.solids.breaking[0].origin).cast<double>();
        EXPECT_NEAR(at.norm(), 0.018, 0.1 * row);  // the last twentieth of a row may be left
        EXPECT_NEAR(at.z(), 0.001 * 0.018 / 0.03, 0.1 * row);
    }
}

TEST(PaintedCracks, OfARingThatMeetsItselfPartTheBody) {
    Simulation s = make_simulation(ringed_ball(0.03));
    EXPECT_TRUE(s.solids.cracks.fronts.empty());
    pull(s, 0.05);
    ASSERT_EQ(s.solids.bodies.size(), 2u);
    for (const SolidBody& body : s.solids.bodies) EXPECT_GT(body.size(), 0.4 * static_cast<double>(s.particles.size()));
}

TEST(PaintedCracks, GoOnAlikeAfterAResume) {
    scene::Scene scene = pulled_bar(along({{0, -0.015, 0.015}, {0, 0.015, 0.015}}, 0.006, 0.5));
    scene.frames.fps = 60;
    Simulation s = make_simulation(scene);
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(advance_frame(s));
    fixture::expect_resumes(s, 6);
}

TEST(PaintedCracks, LieOnTheSurface) {
    EXPECT_THROW(make_simulation(bar(along({{0, -0.015, 0.03}, {0, 0.015, 0.015}}, 0.006))), InputError);
    // From the top to the bottom of the bar, straight through.
    EXPECT_THROW(make_simulation(bar(along({{0, 0, 0.015}, {0.001, 0, -0.015}}, 0.006))), InputError);
}

}  // namespace
}  // namespace thixo
