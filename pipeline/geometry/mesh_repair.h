// Diagnosis of meshes, and small changes to them.
#pragma once

#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

/// Counts and properties of a mesh.
struct MeshReport {
    std::size_t vertices = 0, triangles = 0;
    std::size_t open_edges = 0;            // used by one triangle only (edges compared by position)
    std::size_t bad_edges = 0;             // used by more than two triangles, or twice in the same direction
    std::size_t degenerate_triangles = 0;  // no area or a repeated corner
    Box3 bounds;                           // of the vertices; zero where there are none
    double volume = 0;                     // signed, of the triangles: sum of a.(b x c)/6
    bool closed = false;                   // triangles, and no open or bad edge
    std::size_t void_normals = 0;          // vertices whose normal in the file has no length
};
MeshReport inspect_mesh(const TriangleMesh& mesh);

/// A number for the position of every vertex, below `count`. Equal positions have equal numbers, in the order of their
/// first vertex.
std::vector<Index> position_numbers(const std::vector<Vec3f>& vertices, Index& count);

/// Merges vertices of equal position (bit for bit), in the order of their first use. Keeps positions and triangles
/// alone.
TriangleMesh welded(const TriangleMesh& mesh);

/// Maps vertices by x -> rotation (factor x) + translation, and normals by the rotation. Requires factor > 0.
void transform_mesh(TriangleMesh& mesh, double factor, const Quatd& rotation, const Vec3d& translation);
/// Reverses one triangle, with its texture coordinates.
void turn_triangle(TriangleMesh& mesh, std::size_t k);
/// Reverses every triangle and normal.
void flip_mesh(TriangleMesh& mesh);

}  // namespace thixo
