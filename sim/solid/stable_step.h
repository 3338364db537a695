// How long a sub-step of the solids may be.
#pragma once

#include <vector>

#include "sim/state/solids.h"

namespace thixo {

/// The largest omega^2 of each body's small vibrations about its unstrained rest shape, for `laws` [1/s^2]. It is the
/// largest eigenvalue of M^-1 K, by power iteration on the force routine itself. It therefore holds for any sampling,
/// law and zero-energy stiffness. The result lies below the exact value, by a few per cent at most.
std::vector<double> find_stiffest(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies,
                                  Elements& elements);

/// The rates of vibration and of damping of every body. The damping rate is the omega^2 of a law whose only modulus is
/// the shear modulus eta: bulk stiffness has no part in it.
std::vector<FastestRates> find_fastest_rates(const std::vector<StressLaw>& laws, const std::vector<SolidBody>& bodies,
                                             Elements& elements);

/// The longest sub-step [s]. Leapfrog is stable, with d the largest damping rate and velocities half a step old, for
///     omega^2 dt^2/4 + d dt/2 < 1
/// The step uses 0.64 of this limit. The frequency is that of the rest shape, stiffened as the stiffest element is
/// (stiffening_of), plus the springs of walls and contacts. The damping is that of viscosity times the largest squared
/// stretch, plus the damping of walls and contacts. Where samples meet walls these are contacts. Bounds of bodies and of
/// the contacts between them add up body by body.
double stable_sub_step(const Solids& solids, bool walls);

}  // namespace thixo
