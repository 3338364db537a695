// The pair force of viscosity, and its counterpart at walls: the explicit force and the implicit solve are the same sum.
#pragma once

#include "sim/space/smoothing.h"
#include "sim/space/walls.h"

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

/// The longest step of the explicit force [s]. Its fastest rate is 55 mu/(rho h^2), that of neighbours which meet head
/// on in the packing. The leapfrog's continued velocities are stable up to 1 over that; the rest is for disorder:
///     dt = rho h^2/(80 mu)
inline double viscous_step(double support, double density, double viscosity) {
    return support * support * density / (80 * viscosity);
}

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

}  // namespace thixo
