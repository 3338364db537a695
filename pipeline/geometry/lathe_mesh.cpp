#include <algorithm>
#include <cmath>

#include "pipeline/geometry/primitive_mesh.h"

namespace thixo {
namespace {

constexpr double kSharp = 0.7660444431189780;  // cos 40 degrees

struct Corner {
    Vec2d before, after;  // unit normals at the end of the edge that arrives and at the start of the edge that leaves
};

bool on_axis(const Vec2d& p) { return p.x() == 0; }

/// Outward normal of the edge a -> b of a counter-clockwise polygon.
Vec2d edge_normal(const Vec2d& a, const Vec2d& b) { return Vec2d(b.y() - a.y(), a.x() - b.x()).normalized(); }

Vec2d smooth_normal(const Vec2d& n0, double length0, const Vec2d& n1, double length1) {
    if (length0 > 3 * length1) return n0;
    if (length1 > 3 * length0) return n1;
    return (length1 * n0 + length0 * n1).normalized();
}

Corner corner_at(const Vec2d& previous, const Vec2d& here, const Vec2d& next) {
    const Vec2d n0 = edge_normal(previous, here), n1 = edge_normal(here, next);
    if (on_axis(here)) {
        // At the axis the neighbouring edge is the mirror image of the edge itself.
        const auto at_pole = [](const Vec2d& n) {
            const bool smooth = 2 * n.y() * n.y() - 1 > kSharp;
            return smooth ? Vec2d(0, n.y() > 0 ? 1 : -1) : n;
        };
        return {at_pole(n0), at_pole(n1)};
    }
    if (n0.dot(n1) < kSharp) return {n0, n1};
    const Vec2d n = smooth_normal(n0, (here - previous).norm(), n1, (next - here).norm());
    return {n, n};
}

/// Rings of vertices about the axis. A ring on the axis still has one vertex per segment, each with a normal of its
/// own.
class Lathe {
  public:
    explicit Lathe(int segments) : segments_(segments) {
        for (int i = 0; i < 2 * segments; ++i)
            turn_.push_back({std::cos(kPi * i / segments), std::sin(kPi * i / segments)});
    }

    /// Index of the first vertex of a new ring.
    Index ring(const Vec2d& p, const Vec2d& n) {
        const Index first = static_cast<Index>(mesh.vertices.size());
        for (int i = 0; i < segments_; ++i) {
            const Vec2d& at = turn_[2 * i];
            const Vec2d& facing =
                on_axis(p) ? turn_[2 * i + 1] : at;  // on the axis: the middle of the segment's triangle
            mesh.vertices.push_back(Vec3d(p.x() * at.x(), p.x() * at.y(), p.y()).cast<float>());
            mesh.normals.push_back(Vec3d(n.x() * facing.x(), n.x() * facing.y(), n.y()).cast<float>());
        }
        return first;
    }

    void band(Index from, bool from_pole, Index to, bool to_pole) {
        for (int i = 0; i < segments_; ++i) {
            const Index j = (i + 1) % segments_;
            if (!from_pole) mesh.triangles.push_back({from + i, from + j, to_pole ? to + i : to + j});
            if (!to_pole) mesh.triangles.push_back({from + i, to + j, to + i});
        }
    }

    TriangleMesh mesh;

  private:
    int segments_;
    std::vector<Vec2d> turn_;  // (cos, sin) at every half segment
};

}  // namespace

TriangleMesh lathe_mesh(const std::vector<Vec2d>& profile, int segments) {
    Lathe lathe(std::max(segments, 3));
    const std::size_t n = profile.size();
    std::vector<Corner> corners;
    for (std::size_t k = 0; k < n; ++k)
        corners.push_back(corner_at(profile[(k + n - 1) % n], profile[k], profile[(k + 1) % n]));

    const auto is_surface = [&](std::size_t k) {
        return !on_axis(profile[k]) || !on_axis(profile[(k + 1) % n]);
    };  // edge k -> k+1

    std::vector<Index> arriving(n), leaving(n);
    for (std::size_t k = 0; k < n; ++k) {
        const bool before = is_surface((k + n - 1) % n), after = is_surface(k);
        if (before) arriving[k] = lathe.ring(profile[k], corners[k].before);
        if (after)
            leaving[k] = before && corners[k].after == corners[k].before ? arriving[k]
                                                                         : lathe.ring(profile[k], corners[k].after);
    }
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t m = (k + 1) % n;
        if (is_surface(k)) lathe.band(leaving[k], on_axis(profile[k]), arriving[m], on_axis(profile[m]));
    }
    return std::move(lathe.mesh);
}

}  // namespace thixo
