// Triangle meshes and point sets from OBJ, PLY and STL files, and PLY out.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Reads a mesh by its extension (.obj, .ply, .stl; any case): polygons are cut into triangles, PLY triangle strips
/// unrolled, STL corners welded by position, colours decoded from sRGB, texture coordinates kept where every face has
/// them (PLY: s and t or u and v of the vertices, or a face's list texcoord). Lines may end with LF, CR LF or CR; a
/// byte order mark is skipped. A point set (PLY or OBJ vertices without faces) has no triangles. Where `origin` is
/// given the places of the file are origin + vertices. It is the middle of a mesh that stands far from 0 for its size,
/// so that rounding to single precision spares its shape, and 0 for all others. Throws InputError naming the file and
/// the line or byte: unreadable, unknown format, damaged, index out of range, number not finite.
TriangleMesh read_mesh(const std::string& path, Vec3d* origin = nullptr);

/// The same from bytes in memory; `name` stands for the file in messages.
TriangleMesh parse_obj(std::string_view bytes, const std::string& name, Vec3d* origin = nullptr);
TriangleMesh parse_ply(std::string_view bytes, const std::string& name, Vec3d* origin = nullptr);
TriangleMesh parse_stl(std::string_view bytes, const std::string& name, Vec3d* origin = nullptr);

/// For the readers: gives a mesh its vertices from the places in the file, as read_mesh says.
void set_vertices(TriangleMesh& mesh, const std::vector<Vec3d>& places, Vec3d* origin);

/// Binary little-endian PLY with what the mesh has: positions, normals, colours (uchar, sRGB-coded), triangles and
/// their texture coordinates (list texcoord). Equal meshes give equal bytes.
std::string write_ply(const TriangleMesh& mesh);

}  // namespace thixo
