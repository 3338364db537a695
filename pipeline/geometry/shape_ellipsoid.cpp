// The ellipsoid: distance by the root of one monotone function.
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/geometry/primitive_mesh.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

/// The closest point to y (all components >= 0) on the ellipsoid with the half axes e [m] (Eberly 2013):
///     c_k = e_k^2 y_k/(t + e_k^2)  [m]
/// where t is the largest root of
///     |p(t)| = 1,  p_k = e_k y_k/(t + e_k^2)
/// Newton's method runs on 1/|p|, which is concave and nearly linear to the left of the root. Its steps from there
/// never pass the root (More and Sorensen 1983).
Vec3d closest_on_ellipsoid(const Vec3d& e, const Vec3d& y) {
    int shortest;
    e.minCoeff(&shortest);
    const Eigen::Array3d e2 = e.array().square(), ey = e.array() * y.array();
    double t = (ey - e2).maxCoeff();  // here one |p_k| is 1
    // Convergence is quadratic: the remaining error is far below the last digit of Real.
    const double enough = 1e-3 * double(std::numeric_limits<Real>::epsilon()) * (e2[shortest] + std::abs(t));
    for (int i = 0; i < 40; ++i) {
        const Eigen::Array3d p = (ey > 0).select(ey / (t + e2), 0.0);
        const double size2 = p.square().sum(), bend = (ey > 0).select(p.square() / (t + e2), 0.0).sum();
        const double step = size2 * (std::sqrt(size2) - 1) / bend;
        if (!(step > enough)) break;
        t += step;
    }
    Eigen::Array3d closest = Eigen::Array3d::Zero();
    for (int k = 0; k < 3; ++k)
        if (ey[k] > 0 && t + e2[k] > 0) closest[k] = e2[k] * y[k] / (t + e2[k]);
    // Near the centre, in the symmetry plane of the shortest axis, the closest point lies outside that plane. Its third
    // component follows from
    //     sum_k (c_k/e_k)^2 = 1
    double rest = 1 - (closest / e.array()).square().sum() + square(closest[shortest] / e[shortest]);
    closest[shortest] = e[shortest] * std::sqrt(std::max(rest, 0.0));
    return closest;
}

struct Ellipsoid final : Shape::Node, SlopedNode {
    explicit Ellipsoid(const Vec3d& r) : radii(r) {}
    Real distance(const Vec3& x) const override {
        const Vec3d y = x.cast<double>().cwiseAbs();
        return signed_distance(y, closest_on_ellipsoid(radii, y));
    }
    /// The gradient is the normal at the closest point.
    Real sloped(const Vec3& x, Real, Vec3& slope) const override {
        const Vec3d y = x.cast<double>().cwiseAbs(), closest = closest_on_ellipsoid(radii, y);
        const Vec3d normal = closest.cwiseQuotient(radii.cwiseAbs2()).normalized();
        for (int k = 0; k < 3; ++k) slope[k] = std::copysign(Real(normal[k]), x[k]);
        return signed_distance(y, closest);
    }
    Real signed_distance(const Vec3d& y, const Vec3d& closest) const {
        const double d = (closest - y).norm();
        return Real((y.array() / radii.array()).square().sum() < 1 ? -d : d);
    }
    std::optional<Box3> bounds() const override { return Box3{-radii.cast<Real>(), radii.cast<Real>()}; }
    std::optional<TriangleMesh> exact_mesh(int segments) const override {
        TriangleMesh mesh = sphere_mesh(1, segments);
        for (Vec3f& v : mesh.vertices) v = v.cwiseProduct(radii.cast<float>());
        for (Vec3f& n : mesh.normals) n = n.cwiseQuotient(radii.cast<float>()).normalized();
        return mesh;
    }
    Vec3d radii;
};

}  // namespace

Shape ellipsoid(const Vec3d& radii) {
    for (int k = 0; k < 3; ++k) positive_size(radii[k], "ellipsoid radius");
    return Shape(std::make_shared<Ellipsoid>(radii));
}

}  // namespace thixo
