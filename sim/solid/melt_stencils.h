// The two stencils of matter that melts: how much of each, and the arithmetic of the one that flows.
#pragma once

#include "sim/solid/phases.h"

namespace thixo {

/// All moduli and the damping times a share [1]; yield and creep stay.
StressLaw scaled(const StressLaw& law, Real share);

/// The fastest rates of D by material, at the stiffer of its ends, over a packing.
void find_flow_rates(const scene::Scene& scene, const Smoothing& smoothing, Phases& phases);

/// Elements that begin to melt: D takes over the elastic strain of R, turned into the world.
void seed_flow(const std::vector<std::uint8_t>& which, Solids& solids);

}  // namespace thixo
