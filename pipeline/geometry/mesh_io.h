// Triangle meshes and point sets from OBJ, PLY and STL files, and PLY out.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Reads a mesh by its extension (.obj, .ply, .stl; any case): polygons are cut into triangles, PLY triangle strips
/// unrolled, STL corners welded by position, colours decoded from sRGB, texture coordinates kept where every face has
/// them (PLY: s and t or u and v of the vertices, or a face's list texcoord). A point set (PLY or OBJ vertices without
/// faces) has no triangles. Throws InputError naming the file and the line or byte: unreadable, unknown format,
/// damaged, index out of range, number not finite.
TriangleMesh read_mesh(const std::string& path);

/// The same from bytes in memory; `name` stands for the file in messages.
TriangleMesh parse_obj(std::string_view bytes, const std::string& name);
TriangleMesh parse_ply(std::string_view bytes, const std::string& name);
TriangleMesh parse_stl(std::string_view bytes, const std::string& name);

/// Binary little-endian PLY with what the mesh has: positions, normals, colours (uchar, sRGB-coded), triangles and
/// their texture coordinates (list texcoord). Equal meshes give equal bytes.
std::string write_ply(const TriangleMesh& mesh);

}  // namespace thixo
