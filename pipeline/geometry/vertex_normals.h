// Vertex normals of a mesh from its triangles.
#pragma once

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Unit normals: means of the adjacent triangles' normals, weighted by their angles at the vertex (Thuermer & Wuethrich
/// 1998). At a sharp edge no chain of angles below 40 degrees joins the triangles around a vertex. The triangles beyond
/// it then get a copy of the vertex with a normal of their own.
void add_vertex_normals(TriangleMesh& mesh);

/// Whether every vertex has a normal of non-zero length.
bool has_normals(const TriangleMesh& mesh);

}  // namespace thixo
