// Density and pressure of every particle.
#pragma once

#include <vector>

#include "pipeline/geometry/neighbour_lists.h"
#include "sim/space/smoothing.h"
#include "sim/space/sweep.h"
#include "sim/space/walls.h"
#include "sim/state/materials.h"
#include "sim/state/particles.h"

namespace thixo {

/// Summation density with the walls' share (dissertation 2.3):
///     rho_i = rho0_i (sum_j V0_j w_poly6(r_ij) + integral over walls of w_poly6)      [kg/m^3]
/// It is a number density (Solenthaler & Pajarola 2008): neighbours of another rest density do not blur an interface.
/// Walls are volume maps (Bender et al. 2019). Where not all is liquid (sweep.mixed), pairs and walls are weighed as in
/// sim/loop/coupling.h. In: sweep.place [m, m^3]. Out: particles.density [kg/m^3], sweep.walls. The sum over j includes
/// i.
void compute_density(Particles& particles, const NeighbourLists& neighbours, const Walls& walls,
                     const Smoothing& smoothing, Sweep& sweep);

/// Packs the sweep for the other forces where the implicit solver computes the pressure. sweep.place.w becomes zero;
/// sweep.motion.w and sweep.matter are as below. particles.pressure stays.
void pack_without_pressure(Particles& particles, const Materials& materials, Sweep& sweep);

/// Pressure by the equation of state (dissertation 4.8):
///     P_i = k_gas max((rho_i/rho0)^gamma - 1, 0)      [Pa]
/// The cohesion that 4.15 adds is a force of its own, tension.h. At a free surface the summation density falls below
/// rho0 because the sum has no neighbours beyond it. The liquid is not stretched there. A stiff equation of state would
/// answer with tensions of up to half of k_gas: particles clump (tensile instability), and the surface contracts. The
/// pressure is therefore never negative. Surface tension, which the original got partly from there, is what the scene
/// asks for alone. Volumes follow the same reasoning:
///     V_i = m_i / max(rho_i, rho0)      [m^3]
/// Out: particles.pressure [Pa]; sweep.place.w, sweep.motion.w, sweep.matter.
void compute_pressure(Particles& particles, const Materials& materials, Sweep& sweep);

}  // namespace thixo
