// The material place that belongs to a place of a deformed body: a linear least-squares fit of the elements about it.
#pragma once

#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/point_grid.h"
#include "pipeline/geometry/power_of_two.h"
#include "sim/state/bodies.h"

namespace thixo {

/// The fit has weights w_j = w_poly6(x - x_j, h), means xbar and mbar, and the spread
///     A = sum_j w_j (x_j - xbar)(x_j - xbar)^T
/// The map to the material frame is
///     m(x) = mbar + G (x - xbar)
///     G = (sum_j w_j (m_j - mbar)(x_j - xbar)^T + e R^T) (A + e)^-1,   e = 1e-3 tr A
/// The interpolation weights are
///     W_j = w_j (1/sum w + (x - xbar)^T (A + e)^-1 (x_j - xbar)),   sum_j W_j = 1,  sum_j W_j x_j = x
/// The last equation holds in flat and thin parts only within their plane. Elements say nothing about the direction
/// across a thin part. The map is there the body's rotation R.
struct ElementFit {
    Vec3 material{0, 0, 0};  // m(x)
    Mat3 slope;              // G
    std::vector<Index> element;
    std::vector<Real> weight;  // W
    // Scratch.
    std::vector<Real> slant;
    std::vector<std::pair<Real, Index>> near;  // squared distance, element within the body
};

/// Places of elements in the rest shape.
struct RestPlaces {
    const Elements& e;
    Vec3 operator[](std::size_t j) const { return xyz(e.rest[j]); }
};

/// The elements of a body to which a fit is made. `place` gives their places, by element, in any frame that the
/// material frame turns into by `turn`. `grid` holds the elements of this body alone.
template <class Places>
struct PlacedElements {
    const SolidBody& body;
    const Elements& elements;
    const Places& place;
    const PointGrid& grid;
    const Mat3& turn;
};

/// Fits the elements of a body about the place x. The cells of their grid have at least the size `support`. If fewer
/// than eight lie within `support` [m], the nearest sixteen are taken, however far. Elements far from the nearest one
/// in the rest shape are left out: they belong to another limb that is near by chance.
template <class Places>
void fit_elements(const PlacedElements<Places>& placed, Real support, const Vec3& x, ElementFit& fit) {
    const auto& [body, e, place, grid, turn] = placed;
    constexpr std::size_t kEnough = 8;
    constexpr Real kPrior = Real(1e-3), kLeast = Real(1e-6), kMostSlant = 2;
    fit.near.clear();
    grid.for_each_neighbour(x, support, [&](Index near, Real r2) { fit.near.emplace_back(r2, near); });
    Real reach = support;
    if (fit.near.size() < kEnough) {
        grid.nearest(x, 16, std::numeric_limits<Real>::max(), fit.near);
        reach = std::max(support, Real(1.1) * std::sqrt(fit.near.back().first));
    }
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < fit.near.size(); ++k)
        if (fit.near[k] < fit.near[nearest]) nearest = k;
    const Vec3 middle = xyz(e.rest[body.elements[fit.near[nearest].second]]);
    const Poly6 kernel(reach);
    fit.element.clear();
    fit.weight.clear();
    fit.slant.clear();
    Real sum = 0;
    Vec3 to_mean(0, 0, 0), mean(0, 0, 0);
    for (const auto& [r2, near] : fit.near) {
        const Index j = body.elements[near];
        const Vec3 m = xyz(e.rest[j]) - middle;
        if (m.squaredNorm() > square(2 * support)) continue;
        const Real w = kernel.value(r2) * cube(support);
        fit.element.push_back(j);
        fit.weight.push_back(w);
        sum += w;
        to_mean += w * (place[j] - x);
        mean += w * m;
    }
    to_mean /= sum;
    mean /= sum;
    Mat3 spread = Mat3::Zero(), both = Mat3::Zero();
    for (std::size_t k = 0; k < fit.element.size(); ++k) {
        const Vec3 d = place[fit.element[k]] - x - to_mean, wd = fit.weight[k] * d;
        spread += d * wd.transpose();
        both += (xyz(e.rest[fit.element[k]]) - middle - mean) * wd.transpose();
    }
    // A piece of one or a few elements spans no space: it moves as its body turns.
    const Real prior =
        std::max(kPrior * spread.trace(), kLeast * sum * square(reach)) + std::numeric_limits<Real>::min();
    // In units of a power of two near the reach: the determinant has six lengths, too many for a float's range.
    const Real per_unit2 = square(1 / power_of_two_below(reach));
    Mat3 spanned = spread + prior * Mat3::Identity();
    spanned *= per_unit2;
    Mat3 inverse = spanned.inverse();
    inverse *= per_unit2;
    fit.slope = (both + prior * turn.transpose()) * inverse;
    fit.material = middle + mean - fit.slope * to_mean;
    const Vec3 towards = -(inverse * to_mean);
    // Far from its elements a place has large weights of both signs: these are drawn back to their mean.
    Real positive = 0;
    for (std::size_t k = 0; k < fit.element.size(); ++k) {
        const Real linear = towards.dot(place[fit.element[k]] - x - to_mean);
        positive += std::max(fit.weight[k] * linear, Real(0));
        fit.slant.push_back(linear);
    }
    const Real part = std::min(Real(1), kMostSlant / std::max(positive, std::numeric_limits<Real>::min()));
    for (std::size_t k = 0; k < fit.element.size(); ++k) fit.weight[k] *= 1 / sum + part * fit.slant[k];
}

}  // namespace thixo
