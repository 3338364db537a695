// The discrete operators of the implicit pressure solver: how pressure pushes the particles, and how their motion
// changes density.
#pragma once

#include <vector>

#include "pipeline/geometry/neighbour_lists.h"
#include "sim/space/periodic.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/state/particles.h"

namespace thixo {

/// Relative density s, its gradient, and what the solver's sweeps read, packed. With V0 the rest volume, c the walls'
/// share, p the pressure and k = packed_gradient, the pressure of a packing over its Lagrange multiplier (smoothing.h):
///   s_i  = sum_j V0_j W_ij + c(x_i)                                         the sum includes i
///   F_i  = - 1/k (sum_j V0_i V0_j (p_i + p_j) grad W_ij + V0_i p_i grad c)     [N]
///   s'_i = sum_j V0_j (u_i - u_j).grad W_ij + (u_i - u_wall).grad c            [1/s]
/// F is minus the gradient of sum_i V0_i p_i s_i / k and s' the rate of s: the two operators are transposes of each
/// other, so that pressure does exactly the work of the compression it answers, walls included (Bender & Koschier 2017
/// in volumes, as number densities: Solenthaler & Pajarola 2008). As in Sweep ghosts follow the particles, and one
/// dummy without volume.
struct PressureSystem {
    const Ghosts* ghosts = nullptr;  // of this step; operators bring the packed arrays' ghosts up to date themselves
    Index nobody() const { return static_cast<Index>(ghosts->particles + ghosts->size()); }
    std::vector<Quad> place;   // x [m]; V0 p of the pressure in question [m^3 Pa]
    std::vector<Quad> motion;  // a velocity u [m/s] or acceleration, V0 [m^3]
    std::vector<Quad> slope;   // G = sum_j V0_j grad W_ij + grad c [1/m]; V0/(m k) [m^3/kg]
    // |grad W_ij|/r_ij without the kernel's constant, of the pairs in the lists' order, each list's filled up with
    // zeros to whole lanes: a solve sweeps over them dozens of times, and root and quotient cost as much as the rest of
    // a sweep.
    std::vector<Real> pair_slope;
    std::vector<std::size_t> first_pair;  // of each particle
    std::vector<Real> excess;             // s - 1
    std::vector<Real> rate;               // s' of the velocities packed [1/s]
    std::vector<Real> inverse_diagonal;   // 1/a_i [kg/m]; 0 where nothing is near
};

/// Packs positions and velocities, sums s, G, the rate and the diagonal of the operator pressure -> - s'':
///   a_i = V0_i/k (|G_i|^2/m_i + sum_j V0_j^2 |grad W_ij|^2/m_j)      [m/kg]
/// Out: system; particles.density = rho0 s [kg/m^3]. In: walls, one for each particle.
void measure_density(Particles& particles, const NeighbourLists& neighbours, const Ghosts& ghosts,
                     const std::vector<WallEffect>& walls, const Smoothing& smoothing, PressureSystem& system);

/// F_i/m_i [m/s^2] of a pressure [Pa] with system.place.w packed, into system.motion.
void find_pressure_acceleration(const std::vector<Real>& pressure, const NeighbourLists& neighbours,
                                const Smoothing& smoothing, PressureSystem& system);

/// The ghosts' copies of system.motion: before density_rate, where motion was written.
inline void refresh_motion(PressureSystem& system) { refresh_ghosts(*system.ghosts, system.motion); }

/// s'_i of system.motion [1/s], or s''_i where it holds accelerations. `moving`: less the walls' own motion.
Real density_rate(std::size_t i, const NeighbourLists& neighbours, const std::vector<WallEffect>& walls,
                  const Smoothing& smoothing, const PressureSystem& system, bool moving);

/// The pressure that the forces between particles, and mirrored by walls, carry through i: a third of their virial's
/// trace,
///   (sum_j V0_j (p_i + p_j) (-r.grad W_ij)/2 - p_i d dc/dd) / (3 k)     [Pa]
/// The multipliers p differ from it by what a packing's structure does: 4 % in water that has settled. Requires
/// measure_density of the present places; p may be older.
Real virial_pressure(std::size_t i, const std::vector<Real>& pressure, const NeighbourLists& neighbours,
                     const std::vector<WallEffect>& walls, const Smoothing& smoothing, const PressureSystem& system);

}  // namespace thixo
