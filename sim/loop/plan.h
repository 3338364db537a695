// What acts in a step.
#pragma once

#include "sim/loop/simulation.h"

namespace thixo {

/// Decided once a step, after emission and changes of phase; everything in the step asks it.
struct Plan {
    bool liquid = false;      // pressures, viscosity and cohesion: not among solids alone
    bool neighbours = false;  // something asks for present neighbours: liquids, heat, matter that has melted and frozen
    bool pressure_solve = false;   // the implicit one
    bool viscosity_solve = false;  // the implicit one
    bool solids = false;           // their own sub-steps
};

Plan plan_step(const Simulation& s);

}  // namespace thixo
