// Solids among liquids: the forces of the one on the other. Dissertation 5.10, 6.3.
#pragma once

#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/state/particles.h"
#include "sim/state/solids.h"

namespace thixo {

/// Whether any particle is liquid, if only in part: else there are no SPH forces.
bool any_liquid(const Particles& particles);

/// Packs what the sums over neighbours weigh pairs by where not all is liquid (Sweep::mixed):
///   c_ij = max(b_i, b_j)   pressure, viscosity, of a pair: none between two solid particles
///   s_i  = sum_j V0_j [q W(x_ij)] + sum over rest neighbours V0_j (1 - c_ij) W(rest_ij),   q_ij = max(q_i, q_j)
/// with q = 1 for all that is not bound to a rest shape, b for what is. So a solid at rest has the density of its rest
/// shape, whatever its deformation: it has no SPH pressure of its own.
void pack_phases(const Particles& particles, const Solids& solids, const Smoothing& smoothing, Sweep& sweep);

/// Density and pressure that a solid particle shows: those of its elasticity, as far as it is solid. Takes them from
/// the particles before the SPH sums overwrite them, and puts them back.
struct ElasticState {
    std::vector<Real> density, pressure;
};
void keep_elastic_state(const Particles& particles, ElasticState& kept);
void restore_elastic_state(const ElasticState& kept, Particles& particles);

/// The kick of the liquids' leapfrog, for elements: v <- v + kick a, a the acceleration by pressure and viscosity, at
/// the same instant and over the same time as its reaction on the liquid, so that momentum is conserved to rounding.
/// (The elastic forces are fast and the liquid's slow: multiple time steps after Tuckerman, Berne & Martyna 1992. Held
/// over the sub-steps, as dissertation 6.3 has it, the acceleration would lag behind by half a step and feed every
/// oscillation.)
void push_by_liquid(const Particles& particles, double kick, Solids& solids);

}  // namespace thixo
