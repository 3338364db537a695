// What is wrong with a mesh, and small changes to it.
#pragma once

#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

/// What a mesh is like.
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

/// For every vertex the number of its position: equal positions have equal numbers, below `count`, in the order of
/// their first vertex.
std::vector<Index> position_numbers(const std::vector<Vec3f>& vertices, Index& count);

/// Merges vertices of equal position (bit for bit), drops all but the triangles, keeps the order of first use.
TriangleMesh welded(const TriangleMesh& mesh);

/// x -> rotation (factor x) + translation for vertices, rotation for normals. Requires factor > 0.
void transform_mesh(TriangleMesh& mesh, double factor, const Quatd& rotation, const Vec3d& translation);
/// Turns one triangle round, with its texture coordinates.
void turn_triangle(TriangleMesh& mesh, std::size_t k);
/// Turns every triangle and normal round.
void flip_mesh(TriangleMesh& mesh);

}  // namespace thixo
