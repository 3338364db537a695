// Surface tension and wetting: stress in the surface of liquids, adhesion to walls.
#pragma once

#include <vector>

#include "pipeline/geometry/neighbour_lists.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/space/walls.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"
#include "sim/state/strategy.h"

namespace thixo {

/// What makes the sums of `add_tension` the tension of the scene, from a packing cut at a layer and from what settles
/// in drops.
struct TensionScale {
    TensionScale(const Smoothing& smoothing, const Strategy& strategy);
    Real stress;    // a: over the tension of the stress |g| 1 - g g/|g| [1]
    Real deficit;   // b: over the energy of (1 - c)^2/2 an area [1/m]
    Real adhesion;  // 1 over the integral of w_spiky over the wall, integrated over the packing, an area [1/m]
};

/// Room of one evaluation, of particles and ghosts.
struct TensionScratch {
    std::vector<Real> own, filled;  // V0, V [m^3]
    std::vector<Quad> direct;       // S_xx, S_yy, S_zz [Pa], V [m^3]
    std::vector<Quad> shear;        // S_yz, S_xz, S_xy [Pa], -
};

/// Adds the accelerations f_i/m_i of surface tension, and of adhesion to walls. A continuum with the stress
///   S = gamma delta (1 - n n)        delta = |grad c|, n = grad c/|grad c|
/// in its surface pulls with the force gamma kappa delta n of its curvature (continuum surface stress: Lafaurie et al.
/// 1994, for SPH Hu & Adams 2006). The colour c is the sum of the liquid's volumes; in the two gradients volumes are
/// those that would fill it, so that a surface whose particles have drawn together pulls no more than another:
///   c_i = sum_j V0_j w_ij,   V_i = V0_i/max(c_i, 1/2),   g_i = sum_j V_j grad w_ij
///   S_i = a gamma_i (|g_i| 1 - g_i g_i/|g_i|) + b gamma_i (1 - c_i)+ 1
///   f_i = V_i sum_j V_j (S_i + S_j) grad w_ij
/// The second term, a smaller part of the energy, pulls on whatever lacks neighbours: single drops hold on to the
/// others. a and b (TensionScale) are such that drops of 7 to 11 spacings that have settled have the tension gamma of
/// the scene: within a tenth with `dfsph`, a quarter with `eos` (gate drop). Smaller drops have more, as have thick
/// liquids at rest; agitated ones have less. Pair forces of a liquid's inside vanish but for its disorder. (The
/// cohesion of dissertation 4.15, and any pairwise attraction of its range, needs an inner pressure of dozens of times
/// that of a drop; under it particles are as stiff as a soft solid, and drops do not swing.) Linear momentum is
/// conserved; pairs need not lie along their force, and angular momentum drifts (the gate reports it). Two liquids that
/// touch have no tension between them. Walls have no colour: a liquid by itself wets none. A wall attracts it with the
/// energy, per area, of 2 gamma beta, beta = (1 + cos theta)/2, which by Young and Dupre is the contact angle theta:
///   E = - sum_i V0_i 2 gamma_i e sum_walls beta integral over the wall of w_spiky,   e = TensionScale::adhesion
/// What melts takes part with its liquid share of volume, solids not at all.
/// In: sweep.place. Adds to particles.acceleration [m/s^2]. Nothing where no material has tension.
void add_tension(Particles& particles, const NeighbourLists& neighbours, const Walls& walls, const Smoothing& smoothing,
                 const TensionScale& scale, const std::vector<MaterialParams>& materials, const Sweep& sweep,
                 TensionScratch& scratch);

}  // namespace thixo
