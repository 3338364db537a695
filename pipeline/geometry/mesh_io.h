// Triangle meshes and point sets from OBJ, PLY and STL files, PLY out, and what is wrong with a mesh.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

/// Reads a mesh by its extension (.obj, .ply, .stl; any case): polygons are cut into triangles, PLY triangle strips unrolled, STL corners
/// welded by position, colours brought to linear [0, 1]. A point set (PLY or OBJ vertices without faces) has no triangles.
/// Throws InputError naming the file and the line or byte: unreadable, unknown format, damaged, index out of range, number not finite.
TriangleMesh read_mesh(const std::string& path);

/// The same from bytes in memory; `name` stands for the file in messages.
TriangleMesh parse_obj(std::string_view bytes, const std::string& name);
TriangleMesh parse_ply(std::string_view bytes, const std::string& name);
TriangleMesh parse_stl(std::string_view bytes, const std::string& name);

/// Binary little-endian PLY with what the mesh has: positions, normals, colours (uchar, linear), triangles. Equal meshes give equal bytes.
std::string write_ply(const TriangleMesh& mesh);

/// What a mesh is like.
struct MeshReport {
    std::size_t vertices = 0, triangles = 0;
    std::size_t open_edges = 0;            // used by one triangle only (edges compared by position)
    std::size_t bad_edges = 0;             // used by more than two triangles, or twice in the same direction
    std::size_t degenerate_triangles = 0;  // no area or a repeated corner
    Box3 bounds;                           // of the vertices; zero where there are none
    double volume = 0;                     // signed, of the triangles: sum of a.(b x c)/6
    bool closed = false;                   // triangles, and no open or bad edge
    bool inside_out = false;               // volume < 0
};
MeshReport inspect_mesh(const TriangleMesh& mesh);

/// Merges vertices of equal position (bit for bit), drops normals and colours, keeps the order of first use.
TriangleMesh welded(const TriangleMesh& mesh);

/// x -> rotation (factor x) + translation for vertices, rotation for normals. Requires factor > 0.
void transform_mesh(TriangleMesh& mesh, double factor, const Quatd& rotation, const Vec3d& translation);
/// Turns every triangle and normal round.
void flip_mesh(TriangleMesh& mesh);

}  // namespace thixo
