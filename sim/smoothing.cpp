#include "sim/smoothing.h"

#include <cmath>

#include "sim/sampling.h"

namespace thixo {

Real packing_distance(Real spacing) { return std::pow(Real(2), Real(1.0 / 6.0)) * spacing; }

Real packed_sum(const Poly6& kernel, Real spacing) {
    const Real support = 1 / std::sqrt(kernel.h2_inv);
    const int reach = static_cast<int>(support / packing_distance(spacing)) + 2;
    double sum = 0;
    for (int k = -reach; k <= reach; ++k)
        for (int j = -2 * reach; j <= 2 * reach; ++j)
            for (int i = -2 * reach; i <= 2 * reach; ++i) sum += kernel.value(packing_site(i, j, k, spacing).squaredNorm());
    return static_cast<Real>(sum * cube(spacing));
}

Smoothing::Smoothing(Real spacing_, Real support_)
    : spacing(spacing_), support(support_ * spacing_), density(support), pressure(support), viscosity(support) {
    density.scale /= packed_sum(density, spacing);
}

}  // namespace thixo
