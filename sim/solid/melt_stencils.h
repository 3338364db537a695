// The two stencils of matter that melts: how much of each, and the arithmetic of the one that flows.
#pragma once

#include "sim/solid/phases.h"

namespace thixo {

/// All moduli and the damping times a share [1]; yield and creep stay.
StressLaw scaled(const StressLaw& law, Real share);

/// What the fastest rates of a packing are over the largest unevenness of its stencils, times a modulus or a viscosity.
void calibrate_rates(const Smoothing& smoothing, Phases& phases);

/// Elements that begin to melt: D takes over the elastic strain of R, turned into the world.
void seed_flow(const std::vector<std::uint8_t>& which, Solids& solids);

}  // namespace thixo
