// Water flows through a funnel into a glass, both with thin walls. The funnel is high enough to hold its splashes.
#pragma once

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "tests/sim/fixture.h"

namespace thixo::fixture {

// The funnel has a wall of 8 mm, and its spout ends in a tumbler with a wall of 6 mm. That is about one spacing of 6
// mm.
inline scene::Scene funnel_scene(double spacing, double fill_radius) {
    scene::Scene s = empty_space();
    s.world.gravity = {0, 0, -9.81};
    s.solver.spacing = spacing;
    scene::Boundary glass;
    glass.name = "glass";
    glass.shape.kind = scene::Revolve{{{0, 0}, {0.056, 0}, {0.056, 0.155}, {0.05, 0.155}, {0.05, 0.006}, {0, 0.006}}};
    scene::Boundary funnel;
    funnel.name = "funnel";
    funnel.shape.kind = scene::Revolve{
        {{0.02, 0.12}, {0.028, 0.12}, {0.098, 0.22}, {0.098, 1.2}, {0.09, 1.2}, {0.09, 0.222}, {0.02, 0.125}}};
    s.world.boundaries = {glass, funnel};
    s.bodies = {body("charge", shape_at({0, 0, 0.285}, scene::Cylinder{fill_radius, 0.09, 0}))};
    return s;
}

struct Outcome {
    std::size_t particles = 0, in_funnel = 0;
    bool finite = true;
    std::map<std::int64_t, std::string> outside;  // id -> (r, z) and frame where first seen there
};
inline Outcome pour(const scene::Scene& scene, int frames) {
    Simulation s = make_simulation(scene);
    Outcome o;
    o.particles = s.particles.size();
    for (int f = 0; f < frames; ++f) {
        advance_frame(s);
        o.in_funnel = 0;
        for (std::size_t i = 0; i < s.particles.size(); ++i) {
            const Vec3& x = s.particles.position[i];
            o.finite = o.finite && x.allFinite();
            const double r = std::hypot(static_cast<double>(x.x()), static_cast<double>(x.y())),
                         z = static_cast<double>(x.z());
            const double cone = z < 0.222 ? 0.02 + 0.07 * (z - 0.125) / 0.097 : 0.09;  // inner radius of the funnel
            if (z >= 0.125 && r < cone)
                ++o.in_funnel;
            else if (!(r < 0.05 && z > 0.006 && z < 0.155))
                o.outside.try_emplace(s.particles.id[i], fmt::format(" frame {}: ({:.4f} {:.4f})", f, r, z));
        }
    }
    return o;
}

/// Pours at this spacing. All numbers are finite, no particle leaves funnel and glass, and none stays behind.
inline void expect_no_leak(double spacing, std::size_t least_particles) {
    const Outcome o = pour(funnel_scene(spacing, 0.055), 30);
    EXPECT_GT(o.particles, least_particles);
    EXPECT_TRUE(o.finite);
    std::string where;
    for (const auto& [id, place] : o.outside) where += place;
    EXPECT_TRUE(o.outside.empty()) << where;
    // No particles are stuck: less than 1 % is still in the funnel.
    EXPECT_LT(o.in_funnel, o.particles / 100);
}

}  // namespace thixo::fixture
