// The bounding-volume hierarchy under MeshQuery: boxes for closest points, dipoles for winding numbers.
#pragma once

#include <array>
#include <vector>

#include "pipeline/geometry/mesh.h"

namespace thixo {

struct TreeTriangle {
    Vec3 a, b, c;
    Index triangle;  // in the mesh
};

struct TreeNode {
    Vec3 lower, upper;   // of the triangles
    Vec3 centre;         // area-weighted
    Vec3 area_normal;    // sum of area * unit normal: the dipole moment of the solid angle
    Real radius;         // of the ball about centre that holds the triangles
    Index first, count;  // leaf: its triangles; inner node: count = 0, children at index + 1 and at first
};

/// Depth-first array of nodes; node 0 is the root. The same mesh gives the same tree.
struct TriangleTree {
    std::vector<TreeNode> nodes;
    std::vector<TreeTriangle> triangles;  // in leaf order
};

/// Splits at the median along the longest axis of the centroids, down to four triangles per leaf. Requires at least one
/// triangle.
TriangleTree build_triangle_tree(std::vector<TreeTriangle> triangles);

}  // namespace thixo
