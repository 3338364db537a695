#include "sim/space/smoothing.h"

#include <cmath>

namespace thixo {

namespace {

/// Sum of term(|x|) over all sites of the packing within `support`, without the origin.
template <class Term>
double sum_over_sites(Real support, Real spacing, Term&& term) {
    const int reach = static_cast<int>(support / packing_distance(spacing)) + 2;
    double sum = 0;
    for (int k = -2 * reach; k <= 2 * reach; ++k)
        for (int j = -2 * reach; j <= 2 * reach; ++j)
            for (int i = -2 * reach; i <= 2 * reach; ++i) {
                if (i == 0 && j == 0 && k == 0) continue;
                const Vec3 x = packing_site(i, j, k, spacing);
                sum += static_cast<double>(term(x.norm(), x.z()));
            }
    return sum;
}

}  // namespace

Real packed_sum(const Poly6& kernel, Real spacing) {
    const Real support = 1 / std::sqrt(kernel.h2_inv);
    const double sum = sum_over_sites(support, spacing, [&](Real r, Real) { return kernel.value(r * r); });
    return static_cast<Real>((sum + static_cast<double>(kernel.value(0))) * cube(spacing));
}

Real packed_gradient(const Spiky& kernel, Real spacing) {
    const double sum =
        sum_over_sites(1 / kernel.h_inv, spacing, [&](Real r, Real) { return -r * kernel.derivative(r); });
    return static_cast<Real>(sum * cube(spacing) / 3);
}

Real packed_gradient(const Poly6& kernel, Real spacing) {
    const double sum = sum_over_sites(1 / std::sqrt(kernel.h2_inv), spacing,
                                      [&](Real r, Real) { return -r * r * kernel.gradient_factor(r * r); });
    return static_cast<Real>(sum * cube(spacing) / 3);
}

Real packed_laplacian(const ViscosityKernel& kernel, Real spacing) {
    const double sum = sum_over_sites(kernel.h, spacing, [&](Real r, Real) { return r * r * kernel.laplacian(r); });
    return static_cast<Real>(sum * cube(spacing) / 6);
}

Real packed_sum(const ConvexSpline& kernel, Real spacing) {
    const double sum = sum_over_sites(1 / kernel.h_inv, spacing, [&](Real r, Real) { return kernel.value(r); });
    return static_cast<Real>((sum + static_cast<double>(kernel.value(0))) * cube(spacing));
}

Real packed_gradient(const ConvexSpline& kernel, Real spacing) {
    const double sum =
        sum_over_sites(1 / kernel.h_inv, spacing, [&](Real r, Real) { return -r * kernel.derivative(r); });
    return static_cast<Real>(sum * cube(spacing) / 3);
}

namespace {

ConvexSpline calibrated(ConvexSpline kernel, Real spacing) {
    kernel.scale /= packed_sum(kernel, spacing);
    return kernel;
}

/// The wall beside which a packing half a layer off it is in balance. It gives a particle of the first layer the share
/// of the missing half of the packing. As a wall has no particles that react, it has twice the gradient.
WallKernel wall_of_packing(const ConvexSpline& kernel, Real spacing) {
    const Real support = 1 / kernel.h_inv, half = Real(0.5) * packing_layer(spacing);
    const auto missing = [&](auto&& term) {
        return static_cast<Real>(cube(spacing)) *
               static_cast<Real>(sum_over_sites(support, spacing, [&](Real r, Real z) {
                   return z < -half ? static_cast<double>(term(r, z)) : 0.0;
               }));
    };
    const Real share = missing([&](Real r, Real) { return kernel.value(r); });
    const Real slope = missing([&](Real r, Real z) { return kernel.derivative(r) * z / r; });
    return WallKernel(support, half, share, -2 * slope);
}

}  // namespace

Smoothing::Smoothing(Real spacing_, Real support_)
    : spacing(spacing_),
      support(support_ * spacing_),
      density(support),
      pressure(support),
      viscosity(support),
      fluid(calibrated(ConvexSpline(support), spacing)),
      fluid_gradient(packed_gradient(fluid, spacing)),
      wall(wall_of_packing(fluid, spacing)) {
    density.scale /= packed_sum(density, spacing);
    pressure.scale /= packed_gradient(pressure, spacing);
    viscosity.laplacian_scale /= packed_laplacian(viscosity, spacing);
}

}  // namespace thixo
