// Forces between particles and from walls, as accelerations.
#pragma once

#include "pipeline/geometry/neighbour_lists.h"
#include "sim/external/outside.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/state/particles.h"

namespace thixo {

struct ForceParams {
    Outside outside;                // accelerations of all matter
    Real artificial_viscosity = 0;  // Monaghan's alpha [1]
};

/// Accelerations a_i = a_outside + f_i/m_i (dissertation 4.6, 4.7 and 6.13; Monaghan 1992). f_i [N] is the sum of
///     pressure
///       - V_i sum_j V_j (P_i + P_j) grad w_spiky(r_ij)
///     viscosity
///       V_i sum_j V_j (mu_i + mu_j)/2 (v_j - v_i) lap w_visc(r_ij)
///     artificial viscosity, s = h/2
///       V_i sum_j V_j alpha rho c s min(v_ij.r_ij, 0)/(r^2 + s^2/100) grad w_spiky
///     pressure of the wall
///       - V_i max(P_i, 0) integral over walls of grad w_spiky
///     viscosity at the wall, which moves with the mirrored velocity
///       V_i mu_i 2 (v_wall - v_i) integral over no-slip walls of lap w_visc
/// (4.6) prints (P_i + P_j)/2. Since sum_j V_j grad w vanishes, sum_j V_j (P_i + P_j) grad w is the gradient of P, and
/// (4.6) is half of it. With that, a column of water would stand under twice its hydrostatic pressure. The wall's term
/// is minus the derivative of the particle's own compression energy by its place; a pair's is the sum of two such
/// terms. A wall that mirrors the pressure as well would have twice the term. It would do work on particles that come
/// and go, and the fluid would never come to rest. The dissertation takes density by poly6 and its force by spiky.
/// These do not belong to one energy either: a fluid at rest is stirred a little all the time. The default of the
/// artificial viscosity brings it to rest. Every term between particles is antisymmetric: linear momentum is conserved
/// to rounding. Walls push and never pull. Where not all is liquid (sweep.mixed), every term of a pair is weighed by c
/// = max(b_i, b_j), and a wall's by b_i. The mean of the viscosities is weighed by b:
///     (b_i mu_i + b_j mu_j)/(b_i + b_j)
/// Solid particles take no gravity here: their own steps add it. In: sweep. Out: particles.acceleration [m/s^2].
void compute_accelerations(Particles& particles, const NeighbourLists& neighbours, const Smoothing& smoothing,
                           const ForceParams& params, const Sweep& sweep);

}  // namespace thixo
