// What acts in a step: the plan.
#pragma once

#include "sim/loop/simulation.h"

namespace thixo {

/// Decided once a step, after emission and changes of phase. All parts of the step read it.
struct Plan {
    bool liquid = false;           // pressures, viscosity and cohesion act: not among solids alone
    bool neighbours = false;       // present neighbours are needed: by liquids, heat, matter that has melted and frozen
    bool pressure_solve = false;   // the implicit one
    bool viscosity_solve = false;  // the implicit one
    bool solids = false;           // solids take their own sub-steps
};

Plan plan_step(const Simulation& sim);

}  // namespace thixo
