// Cuts a polygon in space into triangles.
#pragma once

#include <span>

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Appends the triangles of a simple polygon, convex or not, by cutting ears in the plane of its Newell normal; where
/// none is left (a polygon that crosses itself), a fan. Repeated neighbours are dropped; fewer than three corners give
/// nothing. Requires indices in range.
void add_polygon(TriangleMesh& mesh, std::span<const Index> corners);

/// The same, with the texture coordinates of the corners; a vertex that is there twice has those of its first corner.
void add_polygon(TriangleMesh& mesh, std::span<const Index> corners, std::span<const Vec2f> uvs);

}  // namespace thixo
