#include "sim/fracture/crack_tree.h"

#include <algorithm>

#include "pipeline/geometry/mesh_query.h"

namespace thixo {

CrackTree::CrackTree(const Cracks& cracks, std::span<const Index> triangles) {
    const CrackTriangles& t = cracks.triangles;
    faces_.reserve(triangles.size());
    for (const Index k : triangles) {
        const Vec3 &a = cracks.vertex[t.a[k]], &b = cracks.vertex[t.b[k]], &c = cracks.vertex[t.c[k]];
        faces_.push_back({WayTriangle(a, b, c), b, c, k});
    }
    if (!faces_.empty()) split(0, static_cast<Index>(faces_.size()));
}

void CrackTree::split(Index begin, Index end) {
    const std::size_t at = nodes_.size();
    nodes_.push_back({faces_[begin].a, faces_[begin].a, begin, end});
    for (Index k = begin; k < end; ++k)
        for (const Vec3* x : {&faces_[k].a, &faces_[k].b, &faces_[k].c}) {
            nodes_[at].lower = nodes_[at].lower.cwiseMin(*x);
            nodes_[at].upper = nodes_[at].upper.cwiseMax(*x);
        }
    if (end - begin <= kLeaf) return;
    int axis = 0;
    (nodes_[at].upper - nodes_[at].lower).maxCoeff(&axis);
    const Index middle = begin + (end - begin) / 2;
    const auto place = [&](Index k) { return faces_.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(place(begin), place(middle), place(end), [&](const Face& p, const Face& q) {
        return std::pair(p.a[axis] + p.b[axis] + p.c[axis], p.row) <
               std::pair(q.a[axis] + q.b[axis] + q.c[axis], q.row);
    });
    split(begin, middle);
    nodes_[at].right = static_cast<Index>(nodes_.size());
    split(middle, end);
}

/// Moeller & Trumbore 1997. Edges belong to the triangle, by a part in 10^6: no segment slips through between two.
std::optional<Vec3> CrackTree::crossing(const Face& face, const Vec3& a, const Vec3& b) {
    // Both ends clearly on one side: no crossing. Rounding of the distances to the plane is far below this.
    const Real clear = Real(1e-4) * face.size, at_a = face.normal.dot(a - face.a), at_b = face.normal.dot(b - face.a);
    if ((at_a > clear && at_b > clear) || (at_a < -clear && at_b < -clear)) return std::nullopt;
    constexpr double kEdge = 1e-6;
    const Vec3d o = face.a.cast<double>(), e1 = face.b.cast<double>() - o, e2 = face.c.cast<double>() - o;
    const Vec3d d = (b - a).cast<double>(), p = d.cross(e2);
    const double det = e1.dot(p);
    if (std::abs(det) < 1e-12 * e1.norm() * e2.norm() * d.norm()) return std::nullopt;
    const Vec3d s = a.cast<double>() - o;
    const double u = s.dot(p) / det;
    if (u < -kEdge || u > 1 + kEdge) return std::nullopt;
    const Vec3d q = s.cross(e1);
    const double v = d.dot(q) / det, t = e2.dot(q) / det;
    if (v < -kEdge || u + v > 1 + kEdge || t < 0 || t > 1) return std::nullopt;
    return (a.cast<double>() + t * d).cast<Real>();
}

bool CrackTree::meets(const Node& node, const Segment& s) {
    // Slabs; a box of no thickness is met where the segment passes through it.
    Real from = 0, to = 1;
    for (int k = 0; k < 3; ++k) {
        const Real d = s.way[k], pad = Real(1e-5) * (std::abs(d) + node.upper[k] - node.lower[k]);
        const Real low = node.lower[k] - pad - s.from[k], high = node.upper[k] + pad - s.from[k];
        if (d == 0) {
            if (low > 0 || high < 0) return false;
            continue;
        }
        const Real near = (d > 0 ? low : high) * s.inverse[k], far = (d > 0 ? high : low) * s.inverse[k];
        from = std::max(from, near);
        to = std::min(to, far);
        if (from > to) return false;
    }
    return true;
}

std::optional<CrackTree::Near> CrackTree::nearest(const Vec3& x, Real reach,
                                                  const std::function<bool(Index)>& accepted) const {
    std::optional<Near> best;
    if (nodes_.empty()) return best;
    Real limit = reach;
    std::vector<Index> stack{0};
    while (!stack.empty()) {
        const Index at = stack.back();
        stack.pop_back();
        const Node& node = nodes_[at];
        const Vec3 off = (node.lower - x).cwiseMax(x - node.upper).cwiseMax(0);
        if (off.norm() >= limit) continue;
        if (node.right != 0) {
            stack.push_back(node.right);
            stack.push_back(at + 1);
            continue;
        }
        for (Index k = node.begin; k < node.end; ++k) {
            const Face& f = faces_[k];
            if (!accepted(f.row)) continue;
            const Vec3 place = closest_on_triangle(x, f.a, f.b, f.c);
            const Real distance = (place - x).norm();
            if (!(distance < limit)) continue;
            limit = distance;
            best = Near{f.row, place, distance};
        }
    }
    return best;
}

}  // namespace thixo
