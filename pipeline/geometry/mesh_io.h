// Triangle meshes and point sets from OBJ, PLY and STL files, and PLY out.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Reads a mesh by its extension (.obj, .ply, .stl; any case). Polygons are cut into triangles, PLY triangle strips are
/// unrolled, STL corners are welded by position, and colours are decoded from sRGB. Texture coordinates are kept where
/// every face has them. In PLY these are s and t or u and v of the vertices, or a face's list texcoord. Lines may end
/// with LF, CR LF or CR; a byte order mark is skipped. A point set (PLY or OBJ vertices without faces) has no
/// triangles. Throws InputError that names the file and the line or byte: unreadable, unknown format, damaged, index
/// out of range, number not finite.
/// Where `origin` is given, the places of the file are origin + vertices. It is 0 for meshes near 0. For those far off
/// it is their middle, so that rounding to single precision keeps their shape.
TriangleMesh read_mesh(const std::string& path, Vec3d* origin = nullptr);

/// The same from bytes in memory. Messages use `name` for the file.
TriangleMesh parse_obj(std::string_view bytes, const std::string& name, Vec3d* origin = nullptr);
TriangleMesh parse_ply(std::string_view bytes, const std::string& name, Vec3d* origin = nullptr);
TriangleMesh parse_stl(std::string_view bytes, const std::string& name, Vec3d* origin = nullptr);

/// For the readers: gives a mesh its vertices from the places in the file, as read_mesh says.
void set_vertices(TriangleMesh& mesh, const std::vector<Vec3d>& places, Vec3d* origin);

/// Binary little-endian PLY with the arrays that the mesh has: positions, normals, colours (uchar, sRGB-coded),
/// triangles and their texture coordinates (list texcoord). Equal meshes give equal bytes.
std::string write_ply(const TriangleMesh& mesh);

}  // namespace thixo
