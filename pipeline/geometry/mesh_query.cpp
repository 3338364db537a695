#include "pipeline/geometry/mesh_query.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/geometry/mesh_tree.h"
#include "pipeline/geometry/solid_angle.h"

namespace thixo {
namespace {

// A tree over 2^32 triangles that is split at medians is at most 32 deep. A traversal keeps one node per level waiting.
constexpr int kStack = 64;

Real box_distance2(const TreeNode& node, const Vec3& x) {
    return (node.lower - x).cwiseMax(x - node.upper).cwiseMax(Real(0)).squaredNorm();
}

std::vector<TreeTriangle> checked_triangles(const TriangleMesh& mesh) {
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        if (!(mesh.vertices[i].cwiseAbs().maxCoeff() < 1e9f))
            throw InputError("mesh vertex {} is at ({}, {}, {}); coordinates must be finite and below 1e9", i,
                             mesh.vertices[i].x(), mesh.vertices[i].y(), mesh.vertices[i].z());
    std::vector<TreeTriangle> triangles;
    triangles.reserve(mesh.triangles.size());
    for (Index k = 0; k < mesh.triangles.size(); ++k) {
        const auto& t = mesh.triangles[k];
        for (const Index v : t)
            if (v >= mesh.vertices.size())
                throw InputError("mesh triangle {} names vertex {} of {}; the mesh is damaged", k, v,
                                 mesh.vertices.size());
        const Vec3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        const Vec3d n = (b.cast<double>() - a.cast<double>()).cross(c.cast<double>() - a.cast<double>());
        if (n.squaredNorm() > 0) triangles.push_back({a.cast<Real>(), b.cast<Real>(), c.cast<Real>(), k});
    }
    if (triangles.empty())
        throw InputError("the mesh has no triangle with an area; a surface of triangles is needed here");
    return triangles;
}

}  // namespace

Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    // In double precision: the products cancel where a triangle is a sliver, as of a finely parted cylinder.
    const Vec3d ab = (b - a).cast<double>(), ac = (c - a).cast<double>(), ap = (p - a).cast<double>();
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const Vec3d bp = (p - b).cast<double>();
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3) * ab).cast<Real>();
    const Vec3d cp = (p - c).cast<double>();
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6) * ac).cast<Real>();
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6)) * (ac - ab)).cast<Real>();
    const double sum = va + vb + vc;
    return a + (ab * (vb / sum) + ac * (vc / sum)).cast<Real>();
}

MeshQuery::MeshQuery(TriangleMesh mesh)
    : mesh_(std::move(mesh)),
      tree_(std::make_unique<const TriangleTree>(build_triangle_tree(checked_triangles(mesh_)))) {}
MeshQuery::~MeshQuery() = default;
MeshQuery::MeshQuery(MeshQuery&&) noexcept = default;
MeshQuery& MeshQuery::operator=(MeshQuery&&) noexcept = default;

Box3 MeshQuery::bounds() const { return {tree_->nodes[0].lower, tree_->nodes[0].upper}; }

MeshQuery::Closest MeshQuery::closest(const Vec3& x, Index near) const {
    struct Waiting {
        Index node;
        Real distance2;
    } stack[kStack];
    int top = 0;
    stack[top++] = {0, box_distance2(tree_->nodes[0], x)};
    Real best2 = std::numeric_limits<Real>::max();
    Closest best{std::numeric_limits<Real>::max(), x, 0};  // stays where x is not finite, or too far to be squared
    if (near < mesh_.triangles.size()) {
        const auto& t = mesh_.triangles[near];
        best.point = closest_on_triangle(x, mesh_.vertices[t[0]].cast<Real>(), mesh_.vertices[t[1]].cast<Real>(),
                                         mesh_.vertices[t[2]].cast<Real>());
        best.triangle = near;
        best2 = (best.point - x).squaredNorm();
    }
    while (top > 0) {
        Waiting at = stack[--top];
        if (at.distance2 > best2) continue;
        for (;;) {  // goes down the nearer children, the farther ones wait
            const TreeNode& node = tree_->nodes[at.node];
            if (node.count > 0) {
                for (Index k = node.first; k < node.first + node.count; ++k) {
                    const TreeTriangle& t = tree_->triangles[k];
                    const Vec3 p = closest_on_triangle(x, t.a, t.b, t.c);
                    const Real d2 = (p - x).squaredNorm();
                    if (d2 < best2 || (d2 == best2 && t.triangle < best.triangle))
                        best2 = d2, best.point = p, best.triangle = t.triangle;
                }
                break;
            }
            Waiting first{at.node + 1, box_distance2(tree_->nodes[at.node + 1], x)};
            Waiting second{node.first, box_distance2(tree_->nodes[node.first], x)};
            if (second.distance2 < first.distance2) std::swap(first, second);
            if (second.distance2 <= best2) stack[top++] = second;
            if (first.distance2 > best2) break;
            at = first;
        }
    }
    best.distance = std::sqrt(best2);
    return best;
}

Real MeshQuery::winding_number(const Vec3& x, Real accuracy) const {
    Index stack[kStack];
    int top = 0;
    stack[top++] = 0;
    double angle = 0;  // sum of half solid angles
    while (top > 0) {
        const Index at = stack[--top];
        const TreeNode& node = tree_->nodes[at];
        const Vec3 r = node.centre - x;
        const Real r2 = r.squaredNorm();
        if (r2 > square(accuracy * node.radius)) {
            angle += double(node.area_normal.dot(r) / (r2 * std::sqrt(r2))) / 2;
        } else if (node.count > 0) {
            for (Index k = node.first; k < node.first + node.count; ++k)
                angle += double(half_solid_angle<Vec3>(tree_->triangles[k].a - x, tree_->triangles[k].b - x,
                                                       tree_->triangles[k].c - x));
        } else {
            stack[top++] = node.first;
            stack[top++] = at + 1;
        }
    }
    return Real(angle / (2 * kPi));
}

bool MeshQuery::inside(const Vec3& x) const { return winding_number(x) > Real(0.5); }

Real MeshQuery::signed_distance(const Vec3& x) const {
    const Real d = closest(x).distance;
    return inside(x) ? -d : d;
}

}  // namespace thixo
