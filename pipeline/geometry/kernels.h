// SPH smoothing kernels in 3D. Each is zero for r >= h and integrates to one over its ball.
// Source: dissertation 4.3.2 (Mueller et al. 2003).
// Units: r, h [m]; kernel [m^-3], gradient [m^-4], Laplacian [m^-5].
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

/// The kernel poly6:
///     w(r) = 315/(64 pi h^3) (1 - r^2/h^2)^3  [m^-3]
/// It takes r^2, so that density sums need no square root.
struct Poly6 {
    explicit Poly6(Real support)
        : h2_inv(Real(1) / (support * support)), scale(Real(315.0 / (64.0 * kPi)) / cube(support)) {}
    Real value(Real r2) const {
        const Real q = Real(1) - r2 * h2_inv;
        return q > 0 ? scale * q * q * q : Real(0);
    }
    /// grad w = gradient_factor(r^2) r_vec
    Real gradient_factor(Real r2) const {
        const Real q = Real(1) - r2 * h2_inv;
        return q > 0 ? Real(-6) * scale * h2_inv * q * q : Real(0);
    }
    Real h2_inv, scale;
};

/// The kernel spiky:
///     w(r) = 15/(pi h^3) (1 - r/h)^3  [m^-3]
///     grad w = -45/(pi h^4) (1 - r/h)^2 r_vec/r  [m^-4]
/// Its gradient does not vanish at the centre, so that pressure keeps close particles apart.
struct Spiky {
    explicit Spiky(Real support) : h_inv(Real(1) / support), scale(Real(15.0 / kPi) / cube(support)) {}
    Real value(Real r) const {
        const Real q = Real(1) - r * h_inv;
        return q > 0 ? scale * q * q * q : Real(0);
    }
    /// dw/dr; grad w = derivative(r) r_vec/r
    Real derivative(Real r) const {
        const Real q = Real(1) - r * h_inv;
        return q > 0 ? Real(-3) * scale * h_inv * q * q : Real(0);
    }
    Real h_inv, scale;
};

/// The cubic spline (Monaghan & Lattanzio 1985) with a constant slope for r < h/3, where it would become flatter.
/// Thomas & Couchman 1992 change the gradient alone in this way. With positive parts, (a)+ = max(a, 0):
///     w(r) = 16/(pi (1 + 16/3645) h^3) ((1 - r/h)+^3 - 4 (1/2 - r/h)+^3 + 3 (1/3 - r/h)+^3)  [m^-3]
/// It is smooth enough to serve density and pressure alike. It is convex, so that pressure drives no two particles into
/// one place.
struct ConvexSpline {
    explicit ConvexSpline(Real support)
        : h_inv(Real(1) / support), scale(Real(16.0 / kPi / (1 + 16.0 / 3645)) / cube(support)) {}
    Real value(Real r) const {
        const Real q = r * h_inv, a = part(1 - q), b = part(Real(0.5) - q), c = part(Real(1.0 / 3) - q);
        return scale * (a * a * a - 4 * b * b * b + 3 * c * c * c);
    }
    /// dw/dr; grad w = derivative(r) r_vec/r
    Real derivative(Real r) const {
        const Real q = r * h_inv, a = part(1 - q), b = part(Real(0.5) - q), c = part(Real(1.0 / 3) - q);
        return Real(-3) * scale * h_inv * (a * a - 4 * b * b + 3 * c * c);
    }
    Real h_inv, scale;

  private:
    static Real part(Real a) { return a > 0 ? a : Real(0); }
};

/// The kernel of viscosity, whose Laplacian is positive everywhere:
///     w(r) = 15/(2 pi h^3) (-r^3/(2 h^3) + r^2/h^2 + h/(2 r) - 1)  [m^-3]
///     lap w = 45/(pi h^5) (1 - r/h)  [m^-5]
struct ViscosityKernel {
    explicit ViscosityKernel(Real support)
        : h(support),
          h_inv(Real(1) / support),
          scale(Real(15.0 / (2.0 * kPi)) / cube(support)),
          laplacian_scale(Real(45.0 / kPi) / (cube(support) * square(support))) {}
    /// Requires r > 0: the kernel has a pole at its centre.
    Real value(Real r) const {
        const Real q = r * h_inv;
        return q < 1 ? scale * (Real(-0.5) * q * q * q + q * q + Real(0.5) / q - Real(1)) : Real(0);
    }
    Real derivative(Real r) const {
        const Real q = r * h_inv;
        return q < 1 ? scale * h_inv * (Real(-1.5) * q * q + Real(2) * q - Real(0.5) / (q * q)) : Real(0);
    }
    Real laplacian(Real r) const {
        const Real q = Real(1) - r * h_inv;
        return q > 0 ? laplacian_scale * q : Real(0);
    }
    Real h, h_inv, scale, laplacian_scale;
};

}  // namespace thixo
