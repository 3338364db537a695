// Elastic and plastic forces by moving least squares. Dissertation 5.3, 5.4; Mueller et al. 2004.
#pragma once

#include <algorithm>
#include <vector>

#include "sim/bonds/gradients.h"
#include "sim/bonds/stencil.h"
#include "sim/state/stress_law.h"

namespace thixo {

/// Upper bounds over all elements.
struct StretchBounds {
    Real stretch2 = 1;    // largest eigenvalue of J^T J [1]
    Real stiffening = 1;  // stiffness over that of the rest shape (stiffening_of) [1]
    void add(const StretchBounds& other) {
        stretch2 = std::max(stretch2, other.stretch2);
        stiffening = std::max(stiffening, other.stiffening);
    }
};

/// Under the elastic stretch s the tangent stiffness of sigma = C eps grows. Matter whose permanent shape is thinner
/// than its rest shape is stiffer per displacement, by the largest eigenvalue of C_p^-1:
///     (3 s^2 - 1)/2 |C_p^-1|      [1]
inline Real stiffening_of(Real elastic_stretch2, Real thinning2) {
    return (Real(1.5) * elastic_stretch2 - Real(0.5)) * thinning2;
}

/// Sets the stiffness of every element's zero-energy modes, in rest[].w:
///     c = modulus V / tr A      [N m^2]
void set_zero_energy(const std::vector<StressLaw>& laws, Elements& elements);

/// The forces of all stencils, for laws by Elements::law_of, into `force` [N]. H is as in bonds/gradients.h, and
///     P = A A+
/// P is the identity, but for flat neighbourhoods: there the missing part of J would make strain of a rotation.
/// The deformation gradient and the Green strain, without differences of large numbers, are
///     J = P + H
///     eps = (J^T J - P)/2 = (P H + H^T P + H^T H)/2
/// The second Piola-Kirchhoff stress of the elastic strain eps - eps^p, written eps here, with viscosity eta, is
///     sigma = lambda tr(eps) 1 + 2 mu eps + 2 eta d(eps)/dt      [Pa]
/// Elasticity of a permanent shape is as in stress_of below.
/// The forces of a stencil are those of (5.19), (5.21), (5.22), the volume term only where A has full rank:
///     F = -V (J sigma + k_v (|J| - 1) cof J) A+
///     on j:  F w_ij r_ij
///     on i: -F sum_j w_ij r_ij
/// H does not see the zero-energy modes. Their energy, after Ganzenmueller 2015, is
///     U = c/2 sum_j w_ij |e_ij|^2,   e_ij = u_j - u_i - H r_ij
/// Their forces are its exact gradient:
///     on j: -c w_ij e_ij
///     on i:  c sum_j w_ij e_ij
/// The residual e of the least squares fulfils sum_j w_ij e_ij r_ij^T = 0, so that the change of H drops out.
/// The forces of every stencil add up to no force and no torque. In gather form i sums its own stencil, and from every
/// neighbour j its part in the stencil of j:
///     w_ji (c_j (u_j - u_i) - T_j r_ij),   T = F + c H
/// Velocities are those of half a sub-step before: damping is of first order in the sub-step.
StretchBounds find_stress_forces(const std::vector<StressLaw>& laws, const Elements& elements, StressScratch& scratch,
                                 std::vector<Vec3>& force);

/// Durations of plastic flow before and after the stress of a sub-step is taken [s]. Half of the last sub-step and half
/// of the next one make the split of second order.
struct FlowTimes {
    double before, after;
};
/// The same with plastic flow of every element (plasticity.h), by the strains of the same sweep.
StretchBounds flow_and_find_stress_forces(const std::vector<StressLaw>& laws, const FlowTimes& times,
                                          Elements& elements, StressScratch& scratch, std::vector<Vec3>& force);

/// Plastic flow over dt [s] (5.4.4, plasticity.h), after find_gradients at the same time.
void flow_plastically(const std::vector<StressLaw>& laws, double dt, const std::vector<Mat3>& gradients,
                      Elements& elements);

/// Green strain of element i, of the whole displacement, plastic part included [1].
Symmetric strain_of(const Elements& elements, std::size_t i, const Mat3& gradient);
/// Second Piola-Kirchhoff stress of an elastic strain, of any law, for a permanent shape that is the rest shape [Pa].
Symmetric stress_of(const StressLaw& law, const Elements& elements, const Symmetric& strain);
/// The same for the permanent shape of element i. With e_p of strain_of_shape and C the law, linear in the strain:
///     S = U_p^-1 C(e_p) U_p^-1      [Pa]
Symmetric stress_of(const StressLaw& law, const Elements& elements, std::size_t i, const Symmetric& strain);
/// C(e_p) of element i with gradient H, without viscosity [Pa]. It is the Kirchhoff stress but for a rotation and for the
/// elastic stretch.
Symmetric stress_of_shape(const StressLaw& law, const Elements& elements, std::size_t i, const Mat3& gradient);
/// What of elements that flow does not change where their bonds do. A neighbour that is lost behind a crack changes the
/// estimated strain, by the bend of the displacement about it. That is no deformation: matter that was drawn out
/// unevenly would burst. What the estimate changes by becomes permanent, so that the elastic strain stays.
class KeptStrains {
  public:
    /// `gradients` are those of the present bonds and displacement.
    KeptStrains(const std::vector<StressLaw>& laws, const Elements& elements, const std::vector<Mat3>& gradients);
    /// After the bonds have changed.
    void restore(const std::vector<StressLaw>& laws, Elements& elements) const;

  private:
    std::vector<Symmetric> elastic_;  // of the permanent shape
    std::vector<Symmetric> inverse_;  // of the moment matrix
};

/// Elastic energy of element i with its own law at the present displacement [J]. It is that of the forces:
///     U_i = V (sigma : eps/2 + k_v (|J| - 1)^2/2) + c/2 sum_j w_ij |e_ij|^2
double elastic_energy_of(const StressLaw& law, const Elements& elements, std::size_t i);
/// The stress of element i with gradient H [Pa]: of its elastic strain, plus that of viscosity.
Symmetric total_stress(const StressLaw& law, const Elements& elements, std::size_t i, const Mat3& gradient);

}  // namespace thixo
