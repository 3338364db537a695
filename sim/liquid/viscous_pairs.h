// The pair force of viscosity, and its counterpart at walls: the explicit force and the implicit solve are the same sum.
#pragma once

#include "sim/external/outside.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/space/walls.h"
#include "sim/state/particles.h"

namespace thixo {

/// The pair force on i, of Weiler, Koschier, Brand & Bender 2018:
///     5 V_i V_j mu_ij k(r_ij) ((v_j - v_i).n_ij) n_ij,   n_ij = r_ij/|r_ij|      [N]
/// It is central and therefore free of torque. In the continuum the sum is mu (lap v + 2 grad div v): the stress 2 mu D
/// of an incompressible fluid. It vanishes at a free surface and in a rigid rotation. (A sum along v_j - v_i is
/// mu lap v, which brakes a spinning drop.) The kernel has the moment 1 over the packing,
///     k(r) = 2 |dw_poly6/dr|/r = scale (1 - r^2/h^2)^2,   sum_j V_j r^2 k = 6
/// Its fourth moments are isotropic to 2 % over the packing in any orientation, and also once it is sheared (12 % astray
/// with the spiky kernel).
struct PairKernel {
    explicit PairKernel(const Smoothing& smoothing);
    Real h2_inv, scale;
};

inline constexpr Real kCentral = 5;  // of the central form over the Laplacian: 1/(3 <n_x^2 n_y^2>)

/// W/(5 mu V) of all no-slip walls at a place [1/m^2], and the same times the walls' velocities [1/(m s)]:
///     W/(5 mu V) = sum over no-slip walls of (t (1 - N N^T) + s N N^T)
/// with t and s of wall_friction_of.
struct WallDrag {
    Mat3 friction = Mat3::Zero();
    Vec3 moving{0, 0, 0};
};
WallDrag wall_drag(const Walls& walls, const Vec3& x, Real support, WallCursor& cursor);

/// Friction of a half-space wall at distance d < h, along it and across, over the integral of lap w_visc [1]:
///     t d = integral over the wall of k (n.T)^2 z dV
///     s d = integral over the wall of k (n.N)^2 z dV,   z: distance along N
/// This is the pair sum for a velocity that continues linearly, (v_wall - v) (z/d), for a unit difference.
struct WallFriction {
    double along, across;
};
WallFriction wall_friction_of(double distance, double support);

/// Accelerations of liquids whose pressure the implicit solver finds,
///     a_i = a_outside + f_i/m_i
/// f_i [N] is the explicit viscous force. Its pair forces have the harmonic mean of the viscosities,
///     mu_ij = 2 mu_i mu_j/(mu_i + mu_j)
/// and W_i (v_wall - v_i) of no-slip walls. Both momenta are conserved to rounding. (With an equation of state the force
/// is that of forces.h: its brake calms what that pressure stirs.) In: sweep. Out: particles.acceleration [m/s^2].
void compute_viscous_accelerations(Particles& particles, const SweepInput& input, const Outside& outside);

}  // namespace thixo
