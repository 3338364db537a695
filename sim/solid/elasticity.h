// Elastic and plastic forces by moving least squares. Dissertation 5.3, 5.4; Mueller et al. 2004.
#pragma once

#include <vector>

#include "sim/bonds/gradients.h"
#include "sim/bonds/stencil.h"
#include "sim/state/stress_law.h"

namespace thixo {

/// The stiffness c = modulus V / tr A of every element's zero-energy modes, into rest[].w.
void set_zero_energy(const std::vector<StressLaw>& laws, Elements& elements);

/// Forces [N] of all stencils, for laws by Elements::law_of, into `force`. With H as above, P = A A+ (one, but for flat
/// neighbourhoods, where the rest of J would turn a rotation into strain), and the elastic strain eps - eps^p:
///   J = P + H,   eps = (J^T J - P)/2 = (P H + H^T P + H^T H)/2        no difference of large numbers
///   sigma = lambda tr(eps) 1 + 2 mu eps + 2 eta d(eps)/dt              second Piola-Kirchhoff stress; eta the
///   viscosity F = -V (J sigma + k_v (|J| - 1) cof J) A+                          the volume term only where A has full
///   rank on j: F w_ij r_ij,  on i: -F sum_j w_ij r_ij                       (5.19, 5.21, 5.22)
/// and of the zero-energy modes, displacements that H does not see (after Ganzenmueller 2015). Their energy is taken as
///   U = c/2 sum_j w_ij |e_ij|^2,  e_ij = u_j - u_i - H r_ij;   on j: -c w_ij e_ij, on i: c sum_j w_ij e_ij
/// of which this is the exact gradient: e is what is left by least squares, sum_j w_ij e_ij r_ij^T = 0, so that the
/// change of H drops out. Every stencil's forces add up to no force and no torque. Gather form: i sums its own stencil,
/// and from every neighbour j its part in j's stencil, w_ji (c_j (u_j - u_i) - T_j r_ij), T = F + c H. Velocities are
/// those of half a sub-step ago: damping is of first order in the sub-step. Returns the largest squared stretch of any
/// element, an upper bound of the largest eigenvalue of J^T J.
Real find_stress_forces(const std::vector<StressLaw>& laws, const Elements& elements, StressScratch& scratch,
                        std::vector<Vec3>& force);

/// Plastic flow over dt [s] (5.4.4), after find_gradients at the same time:
///   where |eps - eps^p| > k_yield:  eps^p += min(dt k_creep, 1) (eps - eps^p)
/// and |eps^p| is kept at most at its limit (O'Brien et al. 2002). |.| is the Frobenius norm.
void flow_plastically(const std::vector<StressLaw>& laws, double dt, const std::vector<Mat3>& gradients,
                      Elements& elements);

/// Green strain of element i, of the whole displacement [1].
Symmetric strain_of(const Elements& elements, std::size_t i, const Mat3& gradient);
/// Second Piola-Kirchhoff stress of an elastic strain, of any law [Pa].
Symmetric stress_of(const StressLaw& law, const Elements& elements, const Symmetric& strain);
/// That of element i with gradient H: of its elastic strain, and of viscosity [Pa].
Symmetric whole_stress(const StressLaw& law, const Elements& elements, std::size_t i, const Mat3& gradient);

}  // namespace thixo
