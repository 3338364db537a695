// Plastic flow: how the elastic strain beyond the yield surface becomes permanent.
#pragma once

#include "sim/state/elements.h"
#include "sim/state/stress_law.h"

namespace thixo {

/// The part of an elastic strain of size |e| that is left after dt [s] at constant total strain:
///     d|e|/dt = - k_creep |e|   while |e| is beyond the yield surface k       [1/s]
///     k = k_yield + k_hardening p,   dp = -d|e|
/// The solution is exponential, and ends on the yield surface. It is the same for one step or many:
///     |e(dt)| = max(|e| exp(-k_creep dt), (k + k_hardening |e|)/(1 + k_hardening)),   k of the beginning
/// Returns 1 within the yield surface.
Real remaining_part(const StressLaw& law, Real dt, Real size, Real hardened);

/// Plastic flow of one element over dt [s] at a constant Green strain. `total` flow relaxes the whole elastic strain
///     e = eps - eps^p
/// `deviatoric` flow keeps the volume of the permanent shape, whose metric is C_p = 1 + 2 eps^p. It relaxes the part of
/// e that changes no volume, and det C_p stays (von Mises' flow at any strain):
///     dev e = e - (C_p^-1 : e)/3 C_p
/// |e| is the Frobenius norm. |dev e| is that norm as the permanent shape sees it, |U_p^-1 dev e U_p^-1|. The Kirchhoff
/// stress at yield then stays while a body is drawn out. |eps^p| never exceeds its limit (O'Brien et al. 2002). Total flow then
/// only turns eps^p; deviatoric flow, which could not keep the volume, ends there.
/// `hardened` is p: the size of all flow of the element so far [1]. Returns whether the strain is still beyond the yield
/// surface, and would flow on.
bool flow_plastically(const StressLaw& law, Real dt, const Symmetric& strain, Symmetric& plastic, Real& hardened);

/// The size of the elastic part that flow relaxes [1].
Real flowing_size(const StressLaw& law, const Symmetric& strain, const Symmetric& plastic);

/// Whether elasticity refers to a permanent shape that is not the rest shape. That of total flow always refers to the
/// rest shape (O'Brien et al. 2002).
bool is_reshaped(const StressLaw& law, const Symmetric& plastic);

/// C_p^-1 = U_p^-2 of a permanent shape [1].
Mat3 inverse_metric(const Symmetric& plastic);

/// An elastic strain as the permanent shape sees it, without its rotation:
///     e_p = U_p^-1 e U_p^-1      [1]
Symmetric strain_of_shape(const Symmetric& elastic, const Symmetric& plastic);

/// The plastic strain that leaves an elastic strain of the permanent shape as it is, where the strain itself is estimated
/// anew. With C = 1 + 2 eps it is, of deviatoric flow, that of
///     C_p = C^1/2 (1 + 2 e_p)^-1 C^1/2
Symmetric plastic_beside(const StressLaw& law, const Symmetric& strain, const Symmetric& elastic);

}  // namespace thixo
