// Triangle meshes and point sets from OBJ, PLY and STL files, and PLY out.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Reads a mesh by its extension (.obj, .ply, .stl; any case). Polygons are cut into triangles, PLY triangle strips are
/// unrolled, STL corners are welded by position, and colours are decoded from sRGB. Texture coordinates are kept where
/// every face has them. In PLY these are s and t or u and v of the vertices, or a face's list texcoord. A point set
/// (PLY or OBJ vertices without faces) has no triangles. Throws InputError that names the file and the line or byte:
/// unreadable, unknown format, damaged, index out of range, number not finite.
TriangleMesh read_mesh(const std::string& path);

/// The same from bytes in memory. Messages use `name` for the file.
TriangleMesh parse_obj(std::string_view bytes, const std::string& name);
TriangleMesh parse_ply(std::string_view bytes, const std::string& name);
TriangleMesh parse_stl(std::string_view bytes, const std::string& name);

/// Binary little-endian PLY with the arrays that the mesh has: positions, normals, colours (uchar, sRGB-coded),
/// triangles and their texture coordinates (list texcoord). Equal meshes give equal bytes.
std::string write_ply(const TriangleMesh& mesh);

}  // namespace thixo
