// The solid of the simulation benchmarks.
#pragma once

#include <cmath>

#include "tests/sim/fixture.h"

namespace thixo::fixture {

/// A beam 4 x 1 x 1 m of about this many particles, held at one end under gravity. It has no surface.
inline scene::Scene held_beam(double particles, double modulus = 1e6) {
    scene::Scene scene = empty_space();
    scene.world.gravity = {0, 0, -9.81};
    scene.materials[0].elastic.youngs_modulus = modulus;
    scene.materials[0].elastic.poisson_ratio = 0.33;
    scene.materials[0].viscosity = 0;
    scene.solver.spacing = std::cbrt(4 / particles);
    scene.bodies = {body("beam", shape_at({0, 0, 0}, scene::BoxShape{{4, 1, 1}, 0}))};
    scene::Handle wall;
    wall.name = "wall";
    wall.body = "beam";
    wall.region = shape_at({-2, 0, 0}, scene::BoxShape{{0.2, 2, 2}, 0});
    scene.handles = {wall};
    return scene;
}

}  // namespace thixo::fixture
