// Blades that cut solids.
#include "sim/fracture/blades.h"

#include <gtest/gtest.h>

#include "tests/sim/fracture/bars.h"
#include "tests/sim/identity.h"

namespace thixo {
namespace {

constexpr double kSide = 0.03;      // of the bar's section [m]
constexpr double kUntilCut = 0.06;  // s

/// A bar at rest that never breaks, and a blade above it: its edge lies across the bar, from -y to y, and goes down.
scene::Scene bar_and_blade(double x, double half_width, std::vector<scene::Key> motion) {
    scene::Scene s = fixture::breakable_bar(0);
    s.surface.enabled = true;
    s.world.gravity = {0, 0, 0};
    s.frames.fps = 200;
    s.materials[0].fracture.opacity = 0.2;  // parted a tenth of a support behind the edge
    s.blades = {{.name = "knife",
                 .body = "bar",
                 .edge = {{{x, -half_width, 0.02}}, {{x, half_width, 0.02}}},
                 .motion = std::move(motion)}};
    return s;
}
std::vector<scene::Key> down(double by) { return {{.time = 0}, {.time = kUntilCut, .position = {0, 0, -by}}}; }

void run_to(Simulation& s, double time) {
    while (s.clock.time < time) ASSERT_TRUE(advance_frame(s));
}

double fastest(const Simulation& s) {
    double most = 0;
    for (const Vec3& v : s.particles.velocity) most = std::max(most, static_cast<double>(v.norm()));
    return most;
}

using fixture::area_of;

/// Where a body's matter was at the start.
Vec3d at_start(const Simulation& s, Index element) {
    return (xyz(s.solids.elements.rest[element]) + s.solids.breaking[0].origin).cast<double>();
}

/// Every bond that crosses the plane x = `plane`, at z above `above`, is parted.
void expect_parted(const Simulation& s, double plane, double above) {
    const Elements& e = s.solids.elements;
    std::size_t seen = 0;
    for (Index i = 0; i < e.size(); ++i)
        for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
            const Vec3d from = at_start(s, i), to = at_start(s, e.bonds.neighbour[k]);
            const double part = (plane - from.x()) / (to.x() - from.x());
            if (!(part > 0 && part < 1) || from.z() + part * (to.z() - from.z()) < above) continue;
            EXPECT_EQ(e.bonds.visibility[k], 0) << from.transpose() << " to " << to.transpose() << " above " << above;
            ++seen;
        }
    EXPECT_GT(seen, 20u);
}

TEST(Blades, PartABodyInThePlaneOfTheirEdge) {
    constexpr double kAt = 0.011;
    Simulation s = make_simulation(bar_and_blade(kAt, 0.03, down(0.04)));
    run_to(s, kUntilCut + 0.02);
    ASSERT_EQ(s.solids.bodies.size(), 2u);
    for (const SolidBody& body : s.solids.bodies) {
        const bool left = at_start(s, body.elements.front()).x() < kAt;
        for (const Index i : body.elements) EXPECT_EQ(at_start(s, i).x() < kAt, left);
    }
    // The sheet reaches a third of a row out of the body on all sides. Cells are cut off straight: a hundredth more.
    const double row = s.solids.breaking[0].row;
    EXPECT_GT(area_of(s.solids.cracks), 0.99 * square(kSide));
    EXPECT_LT(area_of(s.solids.cracks), 1.01 * square(kSide + 0.6 * row));
    for (const Vec3& m : s.solids.cracks.vertex)
        EXPECT_NEAR(m.x() + s.solids.breaking[0].origin.x(), kAt, 1e-5 * kSide);
    // It pushes nothing aside.
    EXPECT_LT(fastest(s), 1e-6);
}

TEST(Blades, CutFromTheSurfaceOnHoweverFastTheyCome) {
    // 20 m/s from rest, at 24 frames a second: half a metre of way in a frame.
    scene::Scene scene = bar_and_blade(0.011, 0.03, {{.time = 0.01}, {.time = 0.04, .position = {0, 0, -0.6}}});
    for (scene::EdgePoint& p : scene.blades[0].edge) p.at.z() = 0.4;
    scene.frames.fps = 24;
    Simulation s = make_simulation(scene);
    run_to(s, 0.1);
    EXPECT_EQ(s.solids.bodies.size(), 2u);
    EXPECT_GT(area_of(s.solids.cracks), 0.99 * square(kSide));
}

TEST(Blades, HoldWhatTheirEdgeHasNotReached) {
    constexpr double kBottom = 0.003;
    std::vector<scene::Key> motion = down(0.02 - kBottom);
    motion.push_back({.time = 0.08, .position = {0, 0, -0.02 + kBottom}});
    Simulation s = make_simulation(bar_and_blade(0.0005, 0.03, motion));
    run_to(s, 0.08);
    const Breaking& breaking = s.solids.breaking[0];
    expect_parted(s, 0.0005, kBottom + static_cast<double>(breaking.opaque + breaking.row));
    const Elements& e = s.solids.elements;
    for (Index i = 0; i < e.size(); ++i)
        for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
            const bool below = std::max(at_start(s, i).z(), at_start(s, e.bonds.neighbour[k]).z()) < kBottom;
            EXPECT_TRUE(!below || e.bonds.visibility[k] == 1);
        }
}

TEST(Blades, DrawnBackCutNothingAndCutElsewhereTheNextTime) {
    const std::vector<scene::Key> twice = {{.time = 0},
                                           {.time = 0.03, .position = {0, 0, -0.02}},
                                           {.time = 0.06, .position = {0, 0, 0.01}},
                                           {.time = 0.07, .position = {0.03, 0, 0.01}},
                                           {.time = 0.08, .position = {0.03, 0, 0.01}},  // it stands still here
                                           {.time = 0.11, .position = {0.03, 0, -0.03}},
                                           {.time = 0.14, .position = {0.03, 0, 0.01}}};
    Simulation s = make_simulation(bar_and_blade(-0.02, 0.03, twice));
    run_to(s, 0.06);
    const double once = area_of(s.solids.cracks), row = s.solids.breaking[0].row;
    EXPECT_NEAR(once, kSide * 0.015, 2 * row * kSide);
    run_to(s, 0.15);
    EXPECT_EQ(s.solids.cracks.cracks.size(), 2u);
    EXPECT_NEAR(area_of(s.solids.cracks), once + kSide * 0.025, 2 * row * kSide);
    EXPECT_EQ(s.solids.bodies.size(), 1u);
    expect_parted(s, -0.02, 2 * row + s.solids.breaking[0].opaque);
    expect_parted(s, 0.01, -0.01 + 2 * row + s.solids.breaking[0].opaque);
}

TEST(Blades, NarrowerThanTheBodyMakeASlit) {
    constexpr double kHalf = 0.006;
    Simulation s = make_simulation(bar_and_blade(0, kHalf, down(0.05)));
    run_to(s, kUntilCut);
    ASSERT_EQ(s.solids.bodies.size(), 1u);
    const double row = s.solids.breaking[0].row;
    EXPECT_NEAR(area_of(s.solids.cracks), 2 * kHalf * (kSide + 0.6 * row), 0.02 * 2 * kHalf * kSide);
    // At its sides the matter holds.
    const Elements& e = s.solids.elements;
    const auto beside = [&](Index i) { return std::abs(at_start(s, i).y()) > kHalf + 1e-4; };
    for (Index i = 0; i < e.size(); ++i)
        for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
            const Index j = e.bonds.neighbour[k];
            const bool aside = beside(i) && beside(j) && at_start(s, i).y() * at_start(s, j).y() > 0;
            EXPECT_TRUE(!aside || e.bonds.visibility[k] == 1);
        }
}

TEST(Blades, AtRestCutWhatMovesOntoThem) {
    scene::Scene scene = bar_and_blade(0.005, 0.03, {});
    scene.bodies[0].velocity = {0, 0, 1};
    scene.bodies[0].shape.translate = {0, 0, -0.02};
    scene.bodies[0].angular_velocity = {0, 0, 0};
    Simulation s = make_simulation(scene);
    run_to(s, kUntilCut + 0.02);
    ASSERT_EQ(s.solids.bodies.size(), 2u);
    for (const Vec3& m : s.solids.cracks.vertex)
        EXPECT_NEAR(m.x() + s.solids.breaking[0].origin.x(), 0.005, 1e-4 * kSide);
}

TEST(Blades, CutAStretchedBodyWhereTheyAre) {
    // The bar is held half as long again: the place 3 cm from the middle was at 2 cm. Its halves draw back at metres a
    // second while the blade cuts, and the strings that still hold them are drawn out.
    for (const double at : {0.0285, 0.03}) {
        scene::Scene scene = bar_and_blade(at, 0.03, {});
        scene.materials[0].viscosity = 50;
        fixture::draw_ends_apart(scene);
        for (scene::Handle& h : scene.handles)
            h.motion = {{.time = 0}, {.time = 0.2, .position = {h.name == "left" ? -0.025 : 0.025, 0, 0}}};
        scene.blades[0].motion = {{.time = 0.4}, {.time = 0.5, .position = {0, 0, -0.04}}};
        Simulation s = make_simulation(scene);
        run_to(s, 0.4);
        // The sheet passes between the elements that stood on the two sides of the blade, to a tenth of a spacing.
        double left = -1, right = 1;
        for (std::size_t k = 0; k < s.particles.size(); ++k) {
            const double now = s.particles.position[k].x(), was = at_start(s, s.solids.element(s.particles.id[k])).x();
            (now < at ? left : right) = now < at ? std::max(left, was) : std::min(right, was);
        }
        run_to(s, 0.5);
        ASSERT_FALSE(s.solids.cracks.vertex.empty());
        const double room = 0.1 * scene.solver.spacing, origin = s.solids.breaking[0].origin.x();
        double first = 1, last = -1;
        for (const Vec3& m : s.solids.cracks.vertex) {
            first = std::min(first, m.x() + origin);
            last = std::max(last, m.x() + origin);
        }
        EXPECT_GT(last, left - room);
        EXPECT_LT(first, right + room);
        run_to(s, 0.6);
        EXPECT_EQ(s.solids.bodies.size(), 2u) << "blade at " << at;
    }
}

TEST(Blades, GoOnAlikeAfterAResume) {
    Simulation s = make_simulation(bar_and_blade(0.011, 0.03, down(0.04)));
    run_to(s, 0.03);
    ASSERT_TRUE(s.solids.cracks.any());
    fixture::expect_resumes(s, 8);
}

}  // namespace
}  // namespace thixo
