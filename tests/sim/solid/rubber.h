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

/// The half-space below z [m].
inline scene::Boundary floor_at(double z) {
    scene::Boundary floor;
    floor.name = "floor";
    floor.shape = shape_at({0, 0, z}, scene::Plane{});
    return floor;
}

}  // namespace thixo::fixture
