#include "pipeline/geometry/packing.h"

#include <cmath>

namespace thixo {

Real packing_distance(Real spacing) { return std::pow(Real(2), Real(1.0 / 6.0)) * spacing; }

Real packing_layer(Real spacing) { return packing_distance(spacing) * std::sqrt(Real(2.0 / 3.0)); }

Vec3d packing_steps(Real spacing) {
    const double a = packing_distance(spacing);
    return {a, a * std::sqrt(3.0) / 2, packing_layer(spacing)};
}

Vec3 packing_site(int i, int j, int k, Real spacing) {
    const Real a = packing_distance(spacing);
    const Real odd_layer = (k & 1) ? Real(1) : Real(0);
    return a * Vec3(Real(i) + Real(0.5) * static_cast<Real>((j + k) & 1),
                    std::sqrt(Real(3)) / 2 * (Real(j) + odd_layer / 3), std::sqrt(Real(2.0 / 3.0)) * Real(k));
}

}  // namespace thixo
