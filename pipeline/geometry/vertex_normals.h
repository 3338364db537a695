// Vertex normals of a mesh from its triangles.
#pragma once

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Unit normals, the mean of the adjacent triangles' normals weighted by their angle at the vertex (Thuermer &
/// Wuethrich 1998). Triangles about a vertex that no chain of angles below 40 degrees joins get a copy of the vertex
/// with a normal of their own (sharp edges).
void add_vertex_normals(TriangleMesh& mesh);

/// Whether every vertex has a normal with a length.
bool has_normals(const TriangleMesh& mesh);

}  // namespace thixo
