// The matter that tests of solids are made of.
#pragma once

#include "tests/sim/fixture.h"

namespace thixo::fixture {

/// Empty space whose first material is rubber, E = 1e5 Pa, with a viscosity [Pa s].
inline scene::Scene rubber_scene(double viscosity = 0) {
    scene::Scene s = empty_space();
    s.materials[0].elastic.youngs_modulus = 1e5;
    s.materials[0].viscosity = viscosity;
    return s;
}

/// A rubber block of 12 x 6 x 6 cm in empty space with a surface, its middle at the origin.
inline scene::Scene rubber_block_scene(scene::SolidSteps steps = scene::SolidSteps::leapfrog) {
    scene::Scene s = rubber_scene();
    s.solver.solids = steps;
    s.surface.enabled = true;
    s.bodies = {body("block", shape_at({0, 0, 0}, scene::BoxShape{{0.12, 0.06, 0.06}, 0}))};
    return s;
}

}  // namespace thixo::fixture
