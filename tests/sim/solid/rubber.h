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

}  // namespace thixo::fixture
