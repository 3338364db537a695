// A polygon rotated about the z axis.
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/geometry/primitive_mesh.h"
#include "pipeline/geometry/revolve_faces.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

struct Edge {
    Vec2 from, to, along;
    Real inverse_length2;
    bool surface;  // false on the axis, where the edge closes the polygon and bounds nothing
};

struct Revolve final : Shape::Node {
    explicit Revolve(std::vector<Vec2d> polygon) : profile(std::move(polygon)) {
        for (std::size_t k = 0; k < profile.size(); ++k) {
            const Vec2d& a = profile[k];
            const Vec2d& b = profile[(k + 1) % profile.size()];
            edges.push_back({a.cast<Real>(), b.cast<Real>(), (b - a).cast<Real>(), Real(1 / (b - a).squaredNorm()),
                             a.x() > 0 || b.x() > 0});
            const Vec3 low(Real(-a.x()), Real(-a.x()), Real(a.y())), high(Real(a.x()), Real(a.x()), Real(a.y()));
            box = k == 0 ? Box3{low, high} : Box3{box.lower.cwiseMin(low), box.upper.cwiseMax(high)};
        }
    }

    /// Distance to the nearest edge in the half plane of x. A point is inside where a ray away from the axis crosses an
    /// odd number of edges.
    Real distance(const Vec3& x) const override {
        const Vec2 p(std::sqrt(x.x() * x.x() + x.y() * x.y()), x.z());
        Real nearest2 = std::numeric_limits<Real>::max();
        bool inside = false;
        for (const Edge& e : edges) {
            if (!e.surface) continue;  // on the axis: such a ray never crosses it
            const Vec2 q = p - e.from;
            nearest2 = std::min(nearest2, (q - clamp01(q.dot(e.along) * e.inverse_length2) * e.along).squaredNorm());
            // Edges are half-open in z, so that a ray through a corner counts it once.
            const bool above_from = p.y() >= e.from.y(), above_to = p.y() >= e.to.y();
            if (above_from != above_to && (q.x() * e.along.y() < q.y() * e.along.x()) == (e.along.y() > 0))
                inside = !inside;
        }
        const Real d = std::sqrt(nearest2);
        return inside ? -d : d;
    }
    std::optional<Box3> bounds() const override { return box; }
    std::optional<TriangleMesh> exact_mesh(int segments) const override { return lathe_mesh(profile, segments); }
    std::shared_ptr<const FaceTree> faces(Real by) const override { return revolve_faces(profile, by); }

    std::vector<Vec2d> profile;  // counter-clockwise
    std::vector<Edge> edges;
    Box3 box;
};

double signed_area(const std::vector<Vec2d>& p) {
    double twice = 0;
    for (std::size_t k = 0; k < p.size(); ++k) {
        const Vec2d &a = p[k], &b = p[(k + 1) % p.size()];
        twice += a.x() * b.y() - a.y() * b.x();
    }
    return twice / 2;
}

double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

bool cross(const Vec2d& a, const Vec2d& b, const Vec2d& c, const Vec2d& d) {
    return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
}

void check_simple(const std::vector<Vec2d>& p) {
    for (std::size_t i = 0; i < p.size(); ++i)
        for (std::size_t j = i + 2; j < p.size(); ++j)
            if (cross(p[i], p[(i + 1) % p.size()], p[j], p[(j + 1) % p.size()]))
                throw InputError(
                    "revolve profile crosses itself between its points {} and {}; order the points along the outline",
                    i + 1, j + 1);
}

}  // namespace

Shape revolve(const std::vector<Vec2d>& given) {
    double extent = 0;
    for (const Vec2d& p : given)
        extent = std::max(extent, finite_vector(p, "revolve profile point").cwiseAbs().maxCoeff());
    std::vector<Vec2d> profile;
    for (std::size_t k = 0; k < given.size(); ++k) {
        Vec2d p = given[k];
        if (p.x() < -1e-9 * extent)
            throw InputError("revolve profile point {} has r = {}; the profile must lie at r >= 0", k + 1, p.x());
        if (p.x() < 1e-9 * extent) p.x() = 0;
        if (profile.empty() || (p - profile.back()).norm() > 1e-9 * extent) profile.push_back(p);
    }
    if (profile.size() > 1 && (profile.front() - profile.back()).norm() <= 1e-9 * extent) profile.pop_back();
    if (profile.size() < 3)
        throw InputError("revolve profile has {} different points; it needs at least 3", profile.size());
    check_simple(profile);
    const double area = signed_area(profile);
    if (std::abs(area) <= 1e-12 * extent * extent)
        throw InputError("revolve profile encloses no area; its points lie on a line");
    if (area < 0) std::reverse(profile.begin(), profile.end());
    return Shape(std::make_shared<Revolve>(std::move(profile)));
}

}  // namespace thixo
