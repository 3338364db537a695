// Forces between solids and liquids. Dissertation 5.10, 6.3.
#pragma once

#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// Whether any particle is at least partly liquid. Otherwise there are no SPH forces.
bool any_liquid(const Particles& particles);

/// Packs the weights of pairs in the sums over neighbours, where not all is liquid (Sweep::mixed):
///     c_ij = max(b_i, b_j)
///     s_i  = sum_j V0_j [q W(x_ij)] + sum over rest neighbours V0_j (1 - c_ij) W(rest_ij),   q_ij = max(q_i, q_j)
/// Pressure and viscosity of a pair are weighed by c: none between two solid particles. The factor q is 1 for particles
/// that are not bound to a rest shape, and b for those that are. A solid in its rest shape therefore has the density of
/// that shape, whatever its deformation: it has no SPH pressure of its own.
void pack_phases(const Particles& particles, const Solids& solids, const Smoothing& smoothing, Sweep& sweep);

/// Density and pressure that a solid particle shows: those of its elasticity, as far as it is solid. They are saved
/// before the SPH sums overwrite them, and restored afterwards.
struct ElasticState {
    std::vector<Real> density, pressure;
};
void keep_elastic_state(const Particles& particles, ElasticState& saved);
void restore_elastic_state(const ElasticState& saved, Particles& particles);

/// The kick of the liquids' leapfrog for elements, with a the acceleration by pressure and viscosity:
///     v <- v + kick a
/// It acts at the same instant and over the same time as its reaction on the liquid: momentum is conserved to rounding.
/// The elastic forces are fast and the liquid's slow (multiple time steps: Tuckerman, Berne & Martyna 1992).
/// Dissertation 6.3 holds the acceleration over the sub-steps. It would then lag by half a step and feed every
/// oscillation.
void push_by_liquid(const Particles& particles, double kick, Solids& solids);

}  // namespace thixo
