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

/// The factors that give the sums of `add_tension` the tension of the scene. They come from a packing cut at a layer,
/// and from settled drops.
struct TensionScale {
    TensionScale(const Smoothing& smoothing, const Strategy& strategy);
    Real stress;    // a: over the tension of the stress |g| 1 - g g/|g| [1]
    Real deficit;   // b: over the energy of (1 - c)^2/2 per area [1/m]
    Real adhesion;  // e: 1 over the integral of w_spiky over the wall, integrated over the packing, per area [1/m]
};

/// Scratch of one evaluation, of particles and ghosts.
struct TensionScratch {
    std::vector<Real> own, filled;  // V0, V [m^3]
    std::vector<Quad> direct;       // S_xx, S_yy, S_zz [Pa], V [m^3]
    std::vector<Quad> shear;        // S_yz, S_xz, S_xy [Pa], -
    std::vector<Real> taking;       // k V [m^3]
    std::vector<Quad> torque;       // b [Pa m^3], -
    std::vector<Quad> couple;       // o [Pa], -
    std::vector<Mat3> yielding;     // (tr m 1 - m)^-1 [1], of particles alone
};

/// Adds the accelerations f_i/m_i of surface tension, and of adhesion to walls. The surface of a continuum has the
/// stress
///     S = gamma delta (1 - n n),   delta = |grad c|,   n = grad c/|grad c|
/// It pulls with the force gamma kappa delta n of its curvature (continuum surface stress: Lafaurie et al. 1994, for
/// SPH Hu & Adams 2006). The colour c is the sum of the liquid's volumes. The two gradients use the volumes that would
/// fill it, so that a surface whose particles have drawn together pulls no more than another:
///     c_i = sum_j V0_j w_ij,   V_i = V0_i/max(c_i, 1/2),   g_i = sum_j V_j grad w_ij
///     S_i = a gamma_i (|g_i| 1 - g_i g_i/|g_i|) + b gamma_i (1 - c_i)+ 1
///     f_i = V_i sum_j V_j (S_i + S_j - [o_i + o_j]x) grad w_ij      [N]
/// The second term, a smaller part of the energy, pulls on particles that lack neighbours: single drops hold on to the
/// others. TensionScale chooses a and b for settled drops of 7 to 11 spacings. These have the tension gamma of the
/// scene, within a tenth with `dfsph`, a quarter with `eos` (gate drop). The shape of a hanging drop says the same of
/// `dfsph` (gate pendant drop). Smaller drops have more, and so have thick liquids at rest. Agitated liquids have less:
/// waves on a sheet swing as if by 0.6 to 0.73 of the tension (report
/// capillary wave). Pair forces inside a liquid vanish but for its disorder. The cohesion of
/// dissertation 4.15, as any pairwise attraction of its range, needs an inner pressure of dozens of times that of a
/// drop. Particles under it are as stiff as a soft solid, and drops do not swing. Pair forces are opposite: linear
/// momentum is conserved. The stencil of i has a torque V_i a_i where S_i does not share its axes with the
/// neighbourhood. The couples o take it away, so that angular momentum is conserved, too:
///     m_i = - sum_j V_j grad w_ij r_ij^T,   a_i = axial vector of S_i m_i
///     (tr m_i 1 - m_i) o_i = w(0) b_i + k_i sum_j w_ij b_j,   b_j = V_j a_j/(V_j w(0) + sum_k k_k V_k w_jk)
/// A torque is shared among the neighbours. A couple against each stencil's own would keep the packing's order at the
/// surface: a drop of 7 spacings had a fifth more pressure. In a thread of single particles nothing can take a
/// torque along it. There k is 0, where c is 1/2 or less; it is 1 from c = 0.6 on. Two liquids that touch have no tension
/// between them. Walls have no colour: without adhesion a liquid wets none. A wall attracts the liquid with the energy
/// per area 2 gamma beta. By Young and Dupre the contact angle is then theta:
///     beta = (1 + cos theta)/2
///     E = - sum_i V0_i 2 gamma_i e sum_walls beta integral over the wall of w_spiky      [J]
///     e = TensionScale::adhesion
/// Melting matter takes part with its liquid share of volume, solids not at all.
/// In: sweep.place. Adds to particles.acceleration [m/s^2]. Does nothing where no material has tension.
void add_tension(Particles& particles, const SweepInput& input, const TensionScale& scale, const Materials& materials,
                 TensionScratch& scratch);

/// The pull of walls on particle i by adhesion [N], of the surface that `add_tension` has packed. `cursor` is of these
/// walls.
Vec3 adhesion_on(std::size_t i, const Particles& particles, const Walls& walls, const TensionScale& scale,
                 const Materials& materials, const TensionScratch& scratch, WallCursor& cursor);

}  // namespace thixo
