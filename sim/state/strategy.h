// How a scene is solved: the strategy.
#pragma once

namespace thixo {

/// Chosen once, at set-up, from the words of the scene (strategy_of, sim/stage/setup.h). No later code compares those
/// words.
struct Strategy {
    bool incompressible = false;   // pressure by the implicit solver, not by an equation of state
    bool implicit_solids = false;  // solids by Euler's method backwards in time, not by leapfrog
};

}  // namespace thixo
