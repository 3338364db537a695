// What the steps of a frame could not do (pipeline/contract/shortfall.h), from the simulation.
#pragma once

#include <vector>

#include "pipeline/contract/shortfall.h"
#include "sim/loop/simulation.h"

namespace thixo {

/// Of the steps since Simulation::stats was last cleared, and of the present state. In the order of kind and name; the
/// same at any thread count. Requires evaluate() at this time.
std::vector<Shortfall> find_shortfalls(const Simulation& sim);

/// What is known of a run before its first step. An emitter's opening may lie in walls when it starts. A fixed step may be
/// above the limits of matter at rest.
std::vector<Shortfall> expect_shortfalls(const Simulation& at_start);

}  // namespace thixo
