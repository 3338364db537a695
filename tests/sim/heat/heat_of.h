// The heat of all particles, for tests of its conservation.
#pragma once

#include "sim/heat/heat.h"
#include "sim/loop/simulation.h"

namespace thixo::fixture {

/// Enthalpy of all particles [J].
inline double heat_of(const Simulation& s) {
    double sum = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i)
        sum += static_cast<double>(s.particles.mass[i]) *
               enthalpy(s.particles.temperature[i],
                        s.problem.materials[static_cast<std::size_t>(s.particles.material[i])].thermal);
    return sum;
}

}  // namespace thixo::fixture
