// The drawn surface of solids in contact asks only bodies that touch.
#include "sim/surface/contact_surface.h"

#include <gtest/gtest.h>

#include "tests/sim/solid/rubber.h"

namespace thixo {
namespace {

/// Two rubber balls that overlap by a millimetre, and others far from them.
scene::Scene balls(int far) {
    scene::Scene s = fixture::rubber_scene();
    s.surface.enabled = true;
    s.bodies = {fixture::body("a", fixture::shape_at({0, 0, 0}, scene::Sphere{0.03})),
                fixture::body("b", fixture::shape_at({0.059, 0, 0}, scene::Sphere{0.03}))};
    for (scene::Body& body : s.bodies) body.surfels = 2000;
    for (int k = 0; k < far; ++k) {
        s.bodies.push_back(fixture::body(
            "far" + std::to_string(k), fixture::shape_at({0.2 * (k % 5), 1 + 0.2 * (k / 5), 0}, scene::Sphere{0.03})));
        s.bodies.back().surfels = 100;
    }
    return s;
}

Simulation drawn(const scene::Scene& scene) {
    Simulation s = make_simulation(scene);
    fixture::steps(s, 1, 1e-5);
    return s;
}

TEST(DrawnContacts, OfTwoBodiesDoNotDependOnBodiesFarAway) {
    Simulation two = drawn(balls(0)), many = drawn(balls(20));
    SurfaceState apart;
    std::vector<Index> source;
    displace_embedded(two.embedded, two.solids, apart, source);
    refresh_surface(two);
    refresh_surface(many);
    ASSERT_GT(many.surface.size(), two.surface.size());
    std::size_t moved = 0;
    for (std::size_t i = 0; i < two.surface.size(); ++i) {
        EXPECT_EQ(two.surface.surfels.position[i], many.surface.surfels.position[i]);
        EXPECT_EQ(two.surface.surfels.normal[i], many.surface.surfels.normal[i]);
        moved += two.surface.surfels.position[i] != apart.surfels.position[i] ? 1 : 0;
    }
    EXPECT_GT(moved, 4u) << "surfels in contact are moved onto the contact surface";
}

TEST(DrawnContacts, ABodyWithoutAShapeMovesNoSurfel) {
    // The third ball touches the first: some groups of surfels are both of a body that touches others, and of this one.
    scene::Scene scene = balls(0);
    scene.bodies.push_back(scene.bodies[1]);
    scene.bodies[2].name = "c";
    scene.bodies[2].shape.translate = {-0.059, 0, 0};
    Simulation s = drawn(scene);
    s.solids.bodies[1].shape.reset();
    SurfaceState apart;
    std::vector<Index> source;
    displace_embedded(s.embedded, s.solids, apart, source);
    refresh_surface(s);
    std::size_t moved = 0;
    for (std::size_t i = 0; i < s.surface.size(); ++i) {
        const bool same = s.surface.surfels.position[i] == apart.surfels.position[i];
        if (s.surface.body[i] == s.solids.bodies[1].id)
            EXPECT_TRUE(same);
        else
            moved += same ? 0 : 1;
    }
    EXPECT_GT(moved, 4u) << "the other two meet";
}

}  // namespace
}  // namespace thixo
