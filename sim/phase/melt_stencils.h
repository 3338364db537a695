// The two stencils of matter that melts: how much of each, and the arithmetic of the one that flows.
#pragma once

#include "sim/phase/phases.h"

namespace thixo {

/// What the fastest rates of a packing are over the largest unevenness of its stencils, times a modulus or a viscosity.
void calibrate_rates(const Smoothing& smoothing, Softening& phases);

/// Squared extent, in parts of the largest, across which a neighbourhood that has formed by itself is flat.
inline constexpr double kThin = 0.05;

/// The rotation in J = Q S, by Higham's iteration (1986); one where J is nearly singular.
Mat3 rotation_of(const Mat3& j);

/// What is bound to no rest shape may be the body's surface anywhere: half a layer deep [m].
Real surface_depth(const Elements& e, std::size_t i);

/// Elements that begin to melt: D takes over the elastic strain of R, turned into the world.
void seed_flow(const std::vector<std::uint8_t>& which, Solids& solids);

}  // namespace thixo
