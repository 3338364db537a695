#include "pipeline/geometry/match_moments.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace thixo {
namespace {

constexpr double kMostChange = 0.75;  // of a volume
constexpr double kIndistinct = 1e-6;  // of the largest eigenvalue: below it the points cannot tell moments apart
constexpr double kFlat = 1e-3;        // of the largest reach: places across a single layer differ by rounding

using Terms = Eigen::Matrix<double, 10, 1>;

/// A volume, its first and its second moments, each over what the points reach along its axes.
Terms terms_of(double volume, const Vec3d& first, const Mat3d& second, const Vec3d& reach) {
    const Mat3d s = second.cwiseQuotient(reach * reach.transpose());
    Terms t;
    t << volume, first.cwiseQuotient(reach), s.diagonal(), s(1, 2), s(2, 0), s(0, 1);
    return t;
}

Vec3d reach_of(const std::vector<PointMoments>& points) {
    Vec3d reach = Vec3d::Zero();
    for (const PointMoments& p : points) reach = reach.cwiseMax(p.first.cwiseAbs());
    return reach.cwiseMax(Vec3d::Constant(kFlat * reach.maxCoeff() + std::numeric_limits<double>::min()));
}

}  // namespace

double match_moments(const std::vector<PointMoments>& points, const ShapeMoments& shape, std::vector<Real>& volume) {
    double sum = 0;
    for (const Real v : volume) sum += static_cast<double>(v);
    const bool all_free = std::ranges::all_of(points, [](const PointMoments& p) { return p.freedom == 1; });
    const double share = all_free ? shape.volume / sum : 1;
    const Vec3d reach = reach_of(points);
    const auto terms_at = [&](std::size_t k) { return terms_of(1, points[k].first, points[k].second, reach); };
    Eigen::Matrix<double, 10, 10> products = Eigen::Matrix<double, 10, 10>::Zero();
    Terms missing = terms_of(shape.volume, shape.first, shape.second, reach);
    for (std::size_t k = 0; k < points.size(); ++k) {
        const double v = share * static_cast<double>(volume[k]);
        const Terms t = terms_at(k);
        products.noalias() += points[k].freedom * v * t * t.transpose();
        missing -= v * t;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 10, 10>> modes(products);
    const double least = kIndistinct * modes.eigenvalues().maxCoeff();
    Terms change = Terms::Zero();
    for (int a = 0; a < 10; ++a)
        if (const double e = modes.eigenvalues()[a]; e > least)
            change += modes.eigenvectors().col(a) * (modes.eigenvectors().col(a).dot(missing) / e);
    double most = 0;
    const auto change_of = [&](std::size_t k) { return points[k].freedom * change.dot(terms_at(k)); };
    for (std::size_t k = 0; k < points.size(); ++k) most = std::max(most, std::abs(change_of(k)));
    const double part = most > kMostChange ? kMostChange / most : 1;
    for (std::size_t k = 0; k < points.size(); ++k)
        volume[k] = static_cast<Real>(share * static_cast<double>(volume[k]) * (1 + part * change_of(k)));
    return part;
}

double match_moments(const std::vector<Vec3>& places, const std::vector<double>& freedom, const ShapeMoments& shape,
                     std::vector<Real>& volume) {
    const Vec3d centre = shape.first / shape.volume;
    std::vector<PointMoments> points(places.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
        const Vec3d x = places[k].cast<double>() - centre;
        points[k] = {x, x * x.transpose(), freedom.empty() ? 1 : freedom[k]};
    }
    return match_moments(points, moments_about(centre, shape), volume);
}

ShapeMoments moments_about(const Vec3d& point, const ShapeMoments& shape) {
    return {shape.volume, shape.first - shape.volume * point,
            shape.second - shape.first * point.transpose() - point * shape.first.transpose() +
                shape.volume * point * point.transpose()};
}

}  // namespace thixo
