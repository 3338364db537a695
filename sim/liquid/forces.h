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

/// Accelerations a_i = a_outside + f_i/m_i with (dissertation 4.6, 4.7 and 6.13; Monaghan 1992)
///   f_i = - V_i sum_j V_j (P_i + P_j) grad w_spiky(r_ij)                                 pressure
///         + V_i sum_j V_j (mu_i + mu_j)/2 (v_j - v_i) lap w_visc(r_ij)                   viscosity
///         + V_i sum_j V_j alpha rho c s  min(v_ij.r_ij, 0)/(r^2 + s^2/100) grad w_spiky  artificial viscosity, s = h/2
///         - V_i max(P_i, 0) integral over walls of grad w_spiky                          pressure of the wall
///         + V_i mu_i 2 (v_wall - v_i) integral over no-slip walls of lap w_visc          the wall moves with the
///         mirrored velocity
/// (4.6) prints (P_i + P_j)/2. Since sum_j V_j grad w vanishes, sum_j V_j (P_i + P_j) grad w is the gradient of P and
/// (4.6) half of it: a column of water would stand under twice its hydrostatic pressure. The wall's term is minus the
/// derivative of the particle's own compression energy by its place, as that of a pair is the sum of two. A wall that
/// mirrors the pressure as well (twice the term) does work on particles that come and go, and the fluid never rests.
/// Density by poly6 and its force by spiky, as the dissertation has it, do not belong to one energy either: a resting
/// fluid is stirred a little all the time, and the artificial viscosity's default is what brings it to rest. Every term
/// between particles is antisymmetric: linear momentum is conserved to rounding. Walls push and never pull. Where not
/// all is liquid (sweep.mixed) every term of a pair is weighed by c = max(b_i, b_j), a wall's by b_i, and the mean of
/// the viscosities by b: (b_i mu_i + b_j mu_j)/(b_i + b_j). Solid particles take no gravity here: their own steps do
/// that. In: sweep. Out: particles.acceleration [m/s^2].
void compute_accelerations(Particles& particles, const NeighbourLists& neighbours, const Smoothing& smoothing,
                           const ForceParams& params, const Sweep& sweep);

}  // namespace thixo
