// Solids in contact: runs repeat, no body is launched, no body passes through itself, and surfaces are drawn right. The
// laws are in tests/physics/contact_gate_test.cpp.
#include "sim/contact/contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/implicit_surface.h"
#include "tests/sim/identity.h"
#include "tests/sim/solid/rubber.h"

namespace thixo {
namespace {

/// Two bodies fall onto each other and a floor, and slide.
scene::Scene meeting_bodies() {
    scene::Scene s = fixture::rubber_scene(5);
    s.world.gravity = {0, 0, -9.81};
    s.world.boundaries = {fixture::floor_at(-0.031)};
    s.bodies = {fixture::body("lower", fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.1, 0.1, 0.06}, 0})),
                fixture::body("upper", fixture::shape_at({0.02, 0, 0.066}, scene::Sphere{0.035}), {0.3, 0.2, -0.5})};
    s.bodies[1].angular_velocity = {0, 20, 5};
    s.frames.fps = 50;
    return s;
}

TEST(Contact, StateIsTheSameAtAnyThreadCount) {
    fixture::expect_same_at_any_thread_count(meeting_bodies(), [](Simulation& s) {
        for (int k = 0; k < 2; ++k) advance_frame(s);
        EXPECT_GT(s.solids.contacts.nodes.size(), 20u);
    });
}

TEST(Contact, ResumedRunEqualsTheUninterruptedOneBitForBit) {
    Simulation whole = make_simulation(meeting_bodies());
    for (int k = 0; k < 2; ++k) advance_frame(whole);
    Real slip = 0;
    for (const Vec3& s : whole.solids.contacts.nodes.slip) slip = std::max(slip, s.norm());
    EXPECT_GT(slip, 0);  // friction remembers
    fixture::expect_resumes(whole, 2);
}

/// Two bodies start inside each other. Gives the largest speed of any particle within a second, and the distance of
/// their middles after it [m].
std::pair<double, double> released(const scene::Shape& left, const scene::Shape& right) {
    scene::Scene scene = fixture::rubber_scene(5);
    scene.bodies = {fixture::body("left", left), fixture::body("right", right)};
    Simulation s = make_simulation(scene);
    double fastest = 0;
    for (int k = 0; k < 24; ++k) {
        advance_frame(s);
        for (const Vec3& v : s.particles.velocity) fastest = std::max(fastest, static_cast<double>(v.norm()));
    }
    EXPECT_LT(fixture::momentum(s.particles).norm(), 1e-6);  // of 0.1 kg at 0.3 m/s
    return {fastest, (s.solids.bodies[1].place - s.solids.bodies[0].place).norm()};
}

TEST(Contact, BodiesPlacedIntoEachOtherAreNotLaunched) {
    // They are pushed out at kOutwards widths a second, which is 0.04 m/s. The compression of the springs adds less
    // than twice that. The springs alone, at a depth of 20 mm, would give 8 m/s.
    const auto [speed, apart] = released(fixture::shape_at({0, 0, 0}, scene::Sphere{0.03}),
                                         fixture::shape_at({0.04, 0.005, 0}, scene::Sphere{0.03}));
    EXPECT_LT(speed, 0.12);
    EXPECT_GT(apart, 0.055);
    // Boxes that overlap with their sides, too, have no direction outwards that suits all faces. They stay.
    EXPECT_LT(released(fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}),
                       fixture::shape_at({0.04, 0.005, 0}, scene::BoxShape{{0.06, 0.06, 0.06}, 0}))
                  .first,
              0.12);
}

TEST(Contact, BodiesThatStartInEachOtherAreToldOfOnce) {
    const auto said = [](double apart) {
        scene::Scene scene = fixture::rubber_scene(5);
        scene.bodies = {fixture::body("left", fixture::shape_at({0, 0, 0}, scene::Sphere{0.03})),
                        fixture::body("right", fixture::shape_at({apart, 0, 0}, scene::Sphere{0.03}))};
        testing::internal::CaptureStderr();
        make_simulation(scene);
        return testing::internal::GetCapturedStderr();
    };
    const std::string deep = said(0.04);
    EXPECT_NE(deep.find("body 'right' starts 0.0"), std::string::npos) << deep;  // 0.02 m, where samples lie
    EXPECT_NE(deep.find("m deep in body 'left'"), std::string::npos) << deep;
    EXPECT_EQ(std::count(deep.begin(), deep.end(), '\n'), 1) << deep;
    EXPECT_EQ(said(0.0601), "");
}

/// A strip is bent to a hairpin, and its lower arm is held. The upper arm falls onto it and is pulled sideways by a
/// slope of 0.3. Returns how far the end of the upper arm moves sideways, and the speed of the fastest particle at the
/// end.
std::pair<double, double> folded_strip(double friction) {
    scene::Scene scene = fixture::rubber_scene(30);
    scene.materials[0].elastic.youngs_modulus = 3e4;
    scene.materials[0].elastic.friction = friction;
    scene.world.gravity = {0, 3, -10};
    scene::Union hairpin;
    for (const auto& [at, size] :
         std::initializer_list<std::pair<Vec3d, Vec3d>>{{{0, 0, 0}, {0.14, 0.04, 0.02}},
                                                        {{0, 0, 0.04}, {0.14, 0.04, 0.02}},
                                                        {{-0.06, 0, 0.02}, {0.02, 0.04, 0.06}}})
        hairpin.shapes.push_back(fixture::shape_at(at, scene::BoxShape{size, 0}));
    scene.bodies = {fixture::body("strip", fixture::shape_at({0, 0, 0}, hairpin))};
    scene::Handle hold;
    hold.name = "hold";
    hold.body = "strip";
    hold.region = fixture::shape_at({0, 0, 0}, scene::BoxShape{{0.2, 0.1, 0.021}, 0});
    scene.handles = {hold};
    Simulation s = make_simulation(scene);
    std::vector<std::int64_t> end;
    double before = 0, after = 0, fastest = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        if (s.particles.position[i].x() > 0.05f && s.particles.position[i].z() > 0.03f) {
            end.push_back(s.particles.id[i]);
            before += static_cast<double>(s.particles.position[i].y());
        }
    for (int frame = 0; frame < 48; ++frame) advance_frame(s);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        fastest = std::max(fastest, static_cast<double>(s.particles.velocity[i].norm()));
        if (std::ranges::find(end, s.particles.id[i]) != end.end())
            after += static_cast<double>(s.particles.position[i].y());
    }
    return {(after - before) / static_cast<double>(end.size()), fastest};
}

TEST(Contact, AFoldedStripComesToRestOnItselfByFriction) {
    const double slid = folded_strip(0).first;
    const auto [held, fast] = folded_strip(0.8);
    // The slope is within the friction cone, so that the upper arm sticks to the lower one. It moves along no more than
    // the arm yielded before it came down.
    EXPECT_GT(slid, 0.004);
    EXPECT_LT(held, 0.5 * slid);
    EXPECT_LT(fast, 0.005);  // of the 0.6 m/s that it falls with
}

TEST(Contact, ABodyDoesNotPassThroughItself) {
    // The prongs of a fork are 32 mm apart. A force pulls them together that would let them cross by 50 mm.
    scene::Scene scene = fixture::rubber_scene(5);
    scene.materials[0].elastic.youngs_modulus = 2e4;
    scene::Sweep fork;
    for (const Vec3d& at :
         {Vec3d(-0.03, 0, 0.13), Vec3d(-0.03, 0, 0.03), Vec3d(0, 0, 0), Vec3d(0.03, 0, 0.03), Vec3d(0.03, 0, 0.13)})
        fork.points.push_back({at, 0.014});
    scene.bodies = {fixture::body("fork", fixture::shape_at({0, 0, 0}, fork))};
    for (const double side : {-1.0, 1.0}) {
        scene::Handle pull;
        pull.name = side < 0 ? "left" : "right";
        pull.body = "fork";
        pull.region = fixture::shape_at({side * 0.03, 0, 0.12}, scene::Sphere{0.02});
        pull.force = {-side * 0.1, 0, 0};
        scene.handles.push_back(pull);
    }
    Simulation s = make_simulation(scene);
    std::map<std::int64_t, int> side;  // of the prongs' particles
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        if (s.particles.position[i].z() > 0.06f) side[s.particles.id[i]] = s.particles.position[i].x() < 0 ? -1 : 1;
    const Real width = s.problem.smoothing.spacing;
    Real nearest = 1;
    for (int k = 0; k < 24; ++k) {
        advance_frame(s);
        for (std::size_t i = 0; i < s.particles.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (side[s.particles.id[i]] * side[s.particles.id[j]] < 0)
                    nearest = std::min(nearest, (s.particles.position[i] - s.particles.position[j]).norm());
    }
    EXPECT_LT(nearest, width);  // they met
    EXPECT_GT(nearest, Real(0.5) * width);
    EXPECT_LT(fixture::momentum(s.particles).norm(), 1e-5);  // 0.1 N for a second is 0.1 Ns
}

/// The largest depth of a surfel in the other body's surface as it is drawn, in radii.
double deepest(const Simulation& s, Real support) {
    std::vector<Vec3> place[2], normal[2];
    for (std::size_t i = 0; i < s.surface.size(); ++i) {
        place[s.surface.body[i]].push_back(s.surface.surfels.position[i]);
        normal[s.surface.body[i]].push_back(s.surface.surfels.normal[i]);
    }
    double worst = 0;
    for (int b = 0; b < 2; ++b) {
        ImplicitSurface other;
        other.build(place[1 - b], normal[1 - b], support);
        for (const Vec3& x : place[b])
            if (const auto at = other.evaluate(x)) worst = std::max(worst, -static_cast<double>(at->value));
    }
    return worst;
}

TEST(Contact, IsDrawnWhereStiffnessesBalance) {
    // Spheres overlap by 12 mm and have not moved yet. On the contact surface E1 depth1 = E2 depth2.
    for (const double ratio : {1.0, 8.0}) {
        scene::Scene scene = fixture::rubber_scene(5);
        scene.surface.enabled = true;
        scene.materials.push_back(scene.materials[0]);
        scene.materials[1].name = "stiff";
        scene.materials[1].elastic.youngs_modulus *= ratio;
        scene.bodies = {fixture::body("one", fixture::shape_at({0, 0, 0}, scene::Sphere{0.05})),
                        fixture::body("two", fixture::shape_at({0.088, 0, 0}, scene::Sphere{0.05}))};
        scene.bodies[1].material = "stiff";
        for (scene::Body& b : scene.bodies) b.surfels = 2000;
        Simulation s = make_simulation(scene);
        fixture::steps(s, 1, 1e-7);
        refresh_surface(s);
        const Real radius = s.embedded.rest.axis1[0].norm();
        int moved = 0;
        for (std::size_t i = 0; i < s.surface.size(); ++i) {
            const Vec3d x = s.surface.surfels.position[i].cast<double>();
            const double one = 0.05 - x.norm(), two = 0.05 - (x - Vec3d(0.088, 0, 0)).norm();
            const double own = s.surface.body[i] == 0 ? one : two, other = s.surface.body[i] == 0 ? two : one;
            if (other < 1e-5) continue;
            EXPECT_GT(own, -0.05 * radius);
            EXPECT_NEAR((one - ratio * two) / (1 + ratio), 0, 0.05 * radius);
            ++moved;
        }
        EXPECT_GT(moved, 100);
        EXPECT_LT(deepest(s, 2 * radius), 0.05 * radius);
    }
}

TEST(Contact, DrawnBodiesDoNotPenetrateInAnImpact) {
    scene::Scene scene = fixture::rubber_scene(5);
    scene.surface.enabled = true;
    scene.bodies = {fixture::body("one", fixture::shape_at({0, 0, 0}, scene::Sphere{0.05}), {1.5, 0, 0}),
                    fixture::body("two", fixture::shape_at({0.106, 0.02, 0}, scene::BoxShape{{0.1, 0.1, 0.1}, 0.02}))};
    for (scene::Body& b : scene.bodies) b.surfels = 2000;
    scene.frames.fps = 200;
    Simulation s = make_simulation(scene);
    Real most = 0;
    for (int k = 0; k < 8; ++k) {
        advance_frame(s);
        for (const Real d : s.solids.contacts.nodes.depth) most = std::max(most, d);
        const Real radius = s.embedded.rest.axis1[0].norm();
        EXPECT_LT(deepest(s, 2 * radius), 0.05 * radius) << "frame " << k;
    }
    EXPECT_GT(most, 0.0005);  // it did press
}

}  // namespace
}  // namespace thixo
