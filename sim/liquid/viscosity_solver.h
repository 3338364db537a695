// Implicit viscosity: one linear system for the velocities of all particles.
#pragma once

#include <vector>

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/neighbour_lists.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/space/walls.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"

namespace thixo {

struct ViscositySolve {
    double kick = 0;          // dt: how long the viscous force acts [s]
    double tolerance = 1e-3;  // of the residual, see solve_viscosity [1]
    int most_iterations = 1000;
};

struct ViscosityReport {
    int iterations = 0;
    double residual = 0;  // reached [1]
    bool converged = true;
};

/// Scratch of one solve. It is kept, so that a steady simulation allocates nothing.
struct ViscosityScratch {
    /// sqrt(dt kappa_ij) n_ij of kLanes neighbours side by side [sqrt(kg)].
    struct Run {
        Lanes x, y, z;
    };
    struct Block {  // a symmetric matrix
        Real xx, yy, zz, xy, xz, yz;
    };
    std::vector<std::size_t> first;  // run of each particle's list, and the end of the last list
    std::vector<Run> runs;
    std::vector<Quad> matter;              // mu [Pa s], V [near h^3], 1/M [1], -; with ghosts
    std::vector<Block> diagonal, inverse;  // without pairs (mass and walls); inverse of the whole block [kg]
    std::vector<Quad> target;              // velocity without viscosity v* [m/s]
    std::vector<Quad> velocity, residual;  // [m/s], [kg m/s]
    std::vector<Quad> direction;           // with ghosts [m/s]
    std::vector<Quad> product;             // [kg m/s]
    std::vector<double> partial;
};

/// Adds the viscous acceleration (v' - v*)/dt of an implicit step to particles.acceleration. With v* = v + dt a, where
/// a holds all other accelerations, it solves for v':
///     m_i (v'_i - v*_i) = dt sum_j kappa_ij ((v'_j - v'_i).n_ij) n_ij + dt W_i (v_wall - v'_i)
///     kappa_ij = 5 V_i V_j mu_ij k(r_ij) (1/M_i + 1/M_j)/2,   mu_ij = 2 mu_i mu_j/(mu_i + mu_j),   n_ij = r_ij/|r_ij|
///     k(r)     = 2 |dw_poly6/dr|/r,   M_i = sum_j V_j k r_ij^2/6
///     W_i      = 5 V_i mu_i sum over no-slip walls of (t (1 - N N^T) + s N N^T)
/// The pair force is that of viscous_pairs.h. The moment M is 1 in a full and even neighbourhood, and up to 1.1 in a
/// disordered one. It is never taken below 0.9: a free surface rightly misses half of it. The harmonic mean makes the
/// stress continuous where two viscosities meet. A no-slip wall counts as fluid whose velocity continues linearly
/// through the wall's (mirrored: Morris, Fox & Zhu 1997), see wall_friction_of.
///
/// The matrix is symmetric and positive definite. Conjugate gradients solve it, preconditioned with the inverse 3x3
/// blocks. They start from v* plus the last step's change, and end when
///     |r| <= tolerance |M v* + dt W v_wall|,   norms sqrt(sum |.|^2/m)
/// The velocity applied is v' + r/m, that of the pair forces of the solution: both momenta are conserved to rounding at
/// any tolerance. This is backward Euler: unconditionally stable, first order.
/// In: particles.velocity, acceleration, viscous_acceleration (the first guess), sweep.place, volumes in sweep.motion.
/// Out: particles.acceleration, viscous_acceleration [m/s^2].
/// Where not all is liquid (sweep.mixed), walls are weighed by b_i, and pairs by max(b_i, b_j) with the mean
///     mu_ij = (b_i + b_j)/(b_i/mu_i + b_j/mu_j)
ViscosityReport solve_viscosity(Particles& particles, const SweepInput& input, const Materials& materials,
                                const ViscositySolve& params, ViscosityScratch& scratch);

}  // namespace thixo
