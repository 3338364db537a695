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
    for (int k = 0; k < far; ++k)
        s.bodies.push_back(fixture::body(
            "far" + std::to_string(k), fixture::shape_at({0.2 * (k % 5), 1 + 0.2 * (k / 5), 0}, scene::Sphere{0.03})));
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
    ASSERT_GT(many.surface.size(), 10 * two.surface.size());
    std::size_t moved = 0;
    for (std::size_t i = 0; i < two.surface.size(); ++i) {
        EXPECT_EQ(two.surface.surfels.position[i], many.surface.surfels.position[i]);
        EXPECT_EQ(two.surface.surfels.normal[i], many.surface.surfels.normal[i]);
        moved += two.surface.surfels.position[i] != apart.surfels.position[i] ? 1 : 0;
    }
    EXPECT_GT(moved, 4u) << "surfels in contact are moved onto the contact surface";
}

TEST(DrawnContacts, ABodyWithoutAShapeMovesNoSurfel) {
    Simulation s = drawn(balls(0));
    s.solids.bodies[1].shape.reset();
    SurfaceState apart;
    std::vector<Index> source;
    displace_embedded(s.embedded, s.solids, apart, source);
    refresh_surface(s);
    EXPECT_EQ(s.surface.surfels.position, apart.surfels.position);
}

}  // namespace
}  // namespace thixo
