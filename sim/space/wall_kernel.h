// The kernel of a wall in the implicit pressure solver.
#pragma once

#include <cmath>

#include "pipeline/base/math.h"

namespace thixo {

/// A kernel w integrated over a wall's volume. A half-space at distance d adds to the relative density
///     c(d) = a (1 - d/h)^n      for d >= 0
///     c(d) = 2 a - c(-d)        inside
///     w(r) = c''(r)/(2 pi r)    [1/m^3]
/// The fluid's own kernel does not work here. Pressure forces follow from the energy sum_i V0_i p_i s_i. A neighbour
/// counts twice in it, because its own density counts as well, but a wall counts once. With the fluid's kernel a
/// uniform pressure would draw the first layer against the wall. Mirroring the pressure doubles the wall's force, but
/// that force is no gradient of an energy, and the fluid never comes to rest. A steeper c solves both. At half a
/// layer's distance it has the value of the missing fluid, and twice its slope.
struct WallKernel {
    /// c has this value [1] and slope < 0 [1/m] at distance d. n is rounded, so that the slope is met to about 5 %.
    WallKernel(Real support_, Real d, Real share_at, Real slope_at) : support(support_) {
        const Real remaining = Real(1) - d / support;
        power = static_cast<int>(std::round(-slope_at / share_at * support * remaining));
        amplitude = share_at / raise(remaining, power);
    }
    Real value(Real r) const {
        const Real remaining = Real(1) - r / support;
        if (remaining <= 0) return 0;
        return amplitude * static_cast<Real>(power * (power - 1)) / (support * support) * raise(remaining, power - 2) /
               (static_cast<Real>(2 * kPi) * r);
    }
    Real share(Real d) const {
        const Real remaining = std::max(Real(1) - std::abs(d) / support, Real(0));
        const Real beyond = amplitude * raise(remaining, power);
        return d < 0 ? 2 * amplitude - beyond : beyond;
    }
    /// dc/dd [1/m], never positive.
    Real slope(Real d) const {
        const Real remaining = std::max(Real(1) - std::abs(d) / support, Real(0));
        return -amplitude * static_cast<Real>(power) / support * raise(remaining, power - 1);
    }
    /// The distance d at which c has a value in (0, 2 a).
    Real distance(Real share) const {
        const auto outside = [&](Real c) {
            return support * (1 - std::pow(c / amplitude, Real(1) / static_cast<Real>(power)));
        };
        return share <= amplitude ? outside(share) : -outside(2 * amplitude - share);
    }
    Real support, amplitude = 0;
    int power = 0;

  private:
    static Real raise(Real a, int n) {
        Real out = 1;
        for (int k = 0; k < n; ++k) out *= a;
        return out;
    }
};

}  // namespace thixo
