// How long a sub-step of the solids may be.
#pragma once

#include <vector>

#include "sim/state/solids.h"

namespace thixo {

/// The largest omega^2 [1/s^2] of each body's small vibrations about its unstrained rest shape, for `laws`: the largest
/// eigenvalue of M^-1 K by power iteration on the force routine itself, so that it holds for any sampling, law and
/// zero-energy stiffness. From below, within a few per cent.
std::vector<double> find_stiffest(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies,
                                  Elements& elements);

/// Both rates of every body. Viscosity damps as a law of shear modulus eta alone would vibrate, and bulk stiffness has
/// no part in it.
std::vector<FastestRates> find_fastest_rates(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies,
                                             Elements& elements);

/// Leapfrog bears omega^2 dt^2/4 + d dt/2 < 1, d the largest rate of damping, taken with velocities half a step old; of
/// that 0.64 is used. omega^2 is that of the rest shape, times the growth of the tangent stiffness of sigma = C eps
/// under the largest stretch s, (3 s^2 - 1)/2, and that of the springs of walls and contacts; d that of viscosity times
/// s^2, and the damping of both. Bounds of bodies and of contacts between them add up body by body. [s]
double stable_sub_step(const Solids& solids, bool walls);

}  // namespace thixo
