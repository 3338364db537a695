#include "pipeline/geometry/mesh_tree.h"

#include <algorithm>
#include <cmath>

namespace thixo {
namespace {

constexpr Index kLeaf = 4;

Vec3 centroid(const TreeTriangle& t) { return (t.a + t.b + t.c) / 3; }

/// Box, dipole and ball of the triangles [first, first + count).
TreeNode summarise(const std::vector<TreeTriangle>& triangles, Index first, Index count) {
    TreeNode node;
    node.lower = node.upper = triangles[first].a;
    Vec3d moment = Vec3d::Zero(), weighted = Vec3d::Zero();
    double area = 0;
    for (Index k = first; k < first + count; ++k) {
        const TreeTriangle& t = triangles[k];
        node.lower = node.lower.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
        node.upper = node.upper.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
        const Vec3d n = (t.b - t.a).cast<double>().cross((t.c - t.a).cast<double>()) / 2;
        moment += n;
        area += n.norm();
        weighted += n.norm() * centroid(t).cast<double>();
    }
    node.centre = area > 0 ? Vec3((weighted / area).cast<Real>()) : Vec3((node.lower + node.upper) / 2);
    node.area_normal = moment.cast<Real>();
    Real radius2 = 0;
    for (Index k = first; k < first + count; ++k)
        for (const Vec3& p : {triangles[k].a, triangles[k].b, triangles[k].c})
            radius2 = std::max(radius2, (p - node.centre).squaredNorm());
    node.radius = std::sqrt(radius2);
    node.first = first;
    node.count = count;
    return node;
}

void build(TriangleTree& tree, Index first, Index count) {
    const std::size_t here = tree.nodes.size();
    tree.nodes.push_back(summarise(tree.triangles, first, count));
    if (count <= kLeaf) return;

    const auto begin = tree.triangles.begin() + first;
    Vec3 lower = centroid(*begin), upper = lower;
    for (Index k = 0; k < count; ++k) {
        const Vec3 c = centroid(begin[k]);
        lower = lower.cwiseMin(c), upper = upper.cwiseMax(c);
    }
    int axis;
    (upper - lower).maxCoeff(&axis);
    const Index half = count / 2;
    std::nth_element(begin, begin + half, begin + count, [axis](const TreeTriangle& s, const TreeTriangle& t) {
        const Real a = centroid(s)[axis], b = centroid(t)[axis];
        return a != b ? a < b : s.triangle < t.triangle;
    });
    build(tree, first, half);
    const Index right = static_cast<Index>(tree.nodes.size());
    build(tree, first + half, count - half);
    tree.nodes[here].first = right;
    tree.nodes[here].count = 0;
}

}  // namespace

TriangleTree build_triangle_tree(std::vector<TreeTriangle> triangles) {
    TriangleTree tree;
    tree.triangles = std::move(triangles);
    tree.nodes.reserve(tree.triangles.size());
    build(tree, 0, static_cast<Index>(tree.triangles.size()));
    return tree;
}

}  // namespace thixo
