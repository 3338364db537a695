// The two stencils of matter that melts: their laws, and the arithmetic of the one that flows.
#pragma once

#include "sim/phase/phases.h"

namespace thixo {

/// Computes the ratio of a packing's fastest rates to the largest unevenness of its stencils, per modulus and
/// viscosity.
void calibrate_rates(const Smoothing& smoothing, Softening& phases);

/// The rotation Q of J = Q S, by Higham's iteration (1986); the identity where J is nearly singular.
Mat3 rotation_of(const Mat3& j);

/// Depth of an element without a rest shape, half a layer [m]: it may be the body's surface anywhere.
Real surface_depth(const Elements& e, std::size_t i);

/// For elements that begin to melt: D takes over the elastic strain of R, turned into the world.
void seed_flow(const std::vector<std::uint8_t>& which, Solids& solids);

}  // namespace thixo
