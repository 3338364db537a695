// The bar that tests of fracture pull apart.
#pragma once

#include "sim/loop/step.h"
#include "tests/sim/solid/rubber.h"

namespace thixo::fixture {

/// A bar of rubber along x, 12 x 3 x 3 cm, that breaks at this tension [Pa]. The rubber has 1e5 Pa, the spacing is 6 mm.
inline scene::Scene breakable_bar(double strength) {
    scene::Scene s = rubber_scene(20);
    s.solver.spacing = 0.006;
    s.materials[0].fracture.strength = strength;
    s.bodies = {body("bar", shape_at({0, 0, 0}, scene::BoxShape{{0.12, 0.03, 0.03}, 0}))};
    return s;
}

/// Its ends are drawn apart at 5 cm/s each.
inline void draw_ends_apart(scene::Scene& s) {
    for (const int side : {-1, 1}) {
        scene::Handle h;
        h.name = side < 0 ? "left" : "right";
        h.body = "bar";
        h.region = shape_at({side * 0.06, 0, 0}, scene::BoxShape{{0.02, 1, 1}, 0});
        h.motion = {{.time = 0, .position = {0, 0, 0}}, {.time = 1, .position = {side * 0.05, 0, 0}}};
        s.handles.push_back(h);
    }
}

/// The area of all sheets, with what stands out of the body [m^2].
inline double area_of(const Cracks& cracks) {
    double sum = 0;
    const CrackTriangles& t = cracks.triangles;
    for (std::size_t k = 0; k < t.size(); ++k) {
        const Vec3 &a = cracks.vertex[t.a[k]], &b = cracks.vertex[t.b[k]], &c = cracks.vertex[t.c[k]];
        sum += 0.5 * static_cast<double>((b - a).cross(c - a).norm());
    }
    return sum;
}

/// Steps until the body has parted, or `most` seconds have passed.
inline void pull(Simulation& s, double most) {
    while (s.clock.time < most && s.solids.bodies.size() < 2) {
        s.clock.next_frame = s.clock.time + 1;
        step(s);
    }
}

}  // namespace thixo::fixture
