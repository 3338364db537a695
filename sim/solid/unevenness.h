// How much stiffer a stencil is than an even one.
#pragma once

#include "sim/state/elements.h"

namespace thixo {

/// The gradient's squared weights over the element's density:
///     V/m sum_j |w_ij A+ r_ij|^2      [m/kg]
/// Times a modulus this is what a stencil with few or one-sided neighbours adds to omega^2.
inline double unevenness(const Elements& e, std::size_t i) {
    const Mat3 inverse = matrix(e.bonds.moment[i].inverse);
    Real sum = 0;
    for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k)
        sum += (e.bonds.weight[k] * (inverse * bond_vector(e, i, k).cast<Real>())).squaredNorm();
    return static_cast<double>(e.volume[i] / e.mass[i] * sum);
}

}  // namespace thixo
