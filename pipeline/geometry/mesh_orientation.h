// Which way round the triangles of a mesh are wound.
#pragma once

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Winds the triangles of every shell (triangles connected by edges, vertices compared by position) alike, and turns
/// the shells outward. A shell follows the winding of the larger part of its area. A shell inside another one keeps its
/// sense against it: hollows stay hollows. Shells that are not closed have no outside of their own. They are turned
/// together where their signed volume about the middle of the mesh is negative. Normals of the file follow the
/// triangles that were turned. Returns how many were turned; 0 leaves the mesh as it was.
std::size_t orient_outward(TriangleMesh& mesh);

}  // namespace thixo
