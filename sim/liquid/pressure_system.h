// The discrete operators of the implicit pressure solver: the forces of pressure, and the change of density by motion.
#pragma once

#include <vector>

#include "pipeline/geometry/neighbour_lists.h"
#include "sim/space/periodic.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/state/particles.h"

namespace thixo {

/// Relative density s, its gradient, and the packed fields that the solver's sweeps read. V0 is the rest volume, c the
/// walls' share, p the pressure. k = packed_gradient is a packing's pressure over its Lagrange multiplier
/// (smoothing.h):
///     s_i  = sum_j V0_j W_ij + c(x_i)                                         the sum includes i
///     F_i  = - 1/k (sum_j V0_i V0_j (p_i + p_j) grad W_ij + V0_i p_i grad c)     [N]
///     s'_i = sum_j V0_j (u_i - u_j).grad W_ij + (u_i - u_wall).grad c            [1/s]
/// F is minus the gradient of sum_i V0_i p_i s_i / k, and s' is the rate of s. The two operators are transposes of each
/// other: pressure does exactly the work of the compression it resists, walls included. This is Bender & Koschier 2017
/// in volumes, as number densities (Solenthaler & Pajarola 2008). As in Sweep, ghosts follow the particles, then one
/// dummy without volume. Squares of volumes, and of the kernel's gradient, leave single precision at spacings of
/// micrometres and of kilometres. Packed volumes are therefore in units of U, a power of two near the volume of a
/// particle: it changes no other bit.
struct PressureSystem {
    const Ghosts* ghosts = nullptr;  // of this step; the operators refresh the ghosts of the packed arrays themselves
    Index nobody() const { return static_cast<Index>(ghosts->particles + ghosts->size()); }
    Real unit = 1;             // U [m^3]
    std::vector<Quad> place;   // x [m]; V0 p of the pressure in question [U Pa]
    std::vector<Quad> motion;  // a velocity u [m/s] or acceleration, V0 [U]
    std::vector<Quad> slope;   // G = sum_j V0_j grad W_ij + grad c [1/m]; V0/(m k) [m^3/kg]
    // |grad W_ij|/r_ij without the kernel's constant, of the pairs in the order of the lists. Each list is padded with
    // zeros to whole lanes. A solve sweeps over these values dozens of times. Root and quotient would cost as much as
    // all other work of a sweep.
    std::vector<Real> pair_slope;
    std::vector<std::size_t> first_pair;  // of each particle
    std::vector<Real> excess;             // s - 1
    std::vector<Real> rate;               // s' of the velocities packed [1/s]
    std::vector<Real> inverse_diagonal;   // 1/a_i [kg/m]; 0 where nothing is near
};

/// Packs positions and velocities, and sums s, G, the rate and the diagonal of the operator pressure -> - s'':
///     a_i = V0_i/k (|G_i|^2/m_i + sum_j V0_j^2 |grad W_ij|^2/m_j)      [m/kg]
/// In: walls, one for each particle. Out: system; particles.density = rho0 s [kg/m^3].
void measure_density(Particles& particles, const NeighbourLists& neighbours, const Ghosts& ghosts,
                     const std::vector<WallEffect>& walls, const Smoothing& smoothing, PressureSystem& system);

/// Writes F_i/m_i [m/s^2] of a pressure [Pa] into system.motion. system.place.w holds the packed pressure.
void find_pressure_acceleration(const std::vector<Real>& pressure, const NeighbourLists& neighbours,
                                const Smoothing& smoothing, PressureSystem& system);

/// Refreshes the ghosts' copies of system.motion. It is called after a write to motion, before density_rate.
inline void refresh_motion(PressureSystem& system) { refresh_ghosts(*system.ghosts, system.motion); }

/// s'_i of system.motion [1/s], or s''_i where it holds accelerations. `moving` subtracts the walls' own motion.
Real density_rate(std::size_t i, const NeighbourLists& neighbours, const std::vector<WallEffect>& walls,
                  const Smoothing& smoothing, const PressureSystem& system, bool moving);

/// The pressure of the forces through particle i, between particles and mirrored by walls: a third of their virial's
/// trace,
///     (sum_j V0_j (p_i + p_j) (-r.grad W_ij)/2 - p_i d dc/dd) / (3 k)     [Pa]
/// The multipliers p differ from it by the effect of a packing's structure: 4 % in settled water. Requires
/// measure_density of the present places; p may be older.
Real virial_pressure(std::size_t i, const std::vector<Real>& pressure, const NeighbourLists& neighbours,
                     const std::vector<WallEffect>& walls, const Smoothing& smoothing, const PressureSystem& system);

}  // namespace thixo
