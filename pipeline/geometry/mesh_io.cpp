#include "pipeline/geometry/mesh_io.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/geometry/colour_code.h"

namespace thixo {
namespace {

std::string file_bytes(const std::string& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) throw InputError("{}: a folder; name a mesh file", path);
    std::ifstream file(path, std::ios::binary);
    if (!file) throw InputError("{}: cannot be opened: {}; check the path", path, std::strerror(errno));
    std::string bytes(std::istreambuf_iterator<char>(file), {});
    if (file.bad()) throw InputError("{}: cannot be read: {}", path, std::strerror(errno));
    if (bytes.empty()) throw InputError("{}: the file is empty; export it again", path);
    return bytes;
}

void append(std::string& out, const void* data, std::size_t size) { out.append(static_cast<const char*>(data), size); }

}  // namespace

void set_vertices(TriangleMesh& mesh, const std::vector<Vec3d>& places, Vec3d* origin) {
    constexpr double kFar = 16;  // half sizes: up to there rounding costs four bits
    Vec3d from(0, 0, 0);
    if (origin) {
        Vec3d lower = places.empty() ? from : places[0], upper = lower;
        for (const Vec3d& p : places) lower = lower.cwiseMin(p), upper = upper.cwiseMax(p);
        const Vec3d middle = lower + (upper - lower) / 2;
        if (middle.norm() > kFar * (upper - lower).norm() / 2) from = middle;
        *origin = from;
    }
    mesh.vertices.clear();
    mesh.vertices.reserve(places.size());
    for (const Vec3d& p : places) mesh.vertices.push_back((p - from).cast<float>());
}

TriangleMesh read_mesh(const std::string& path, Vec3d* origin) {
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (extension == ".obj") return parse_obj(file_bytes(path), path, origin);
    if (extension == ".ply") return parse_ply(file_bytes(path), path, origin);
    if (extension == ".stl") return parse_stl(file_bytes(path), path, origin);
    throw InputError("{}: '{}' is no known mesh format; use .obj, .ply or .stl", path, extension);
}

std::string write_ply(const TriangleMesh& mesh) {
    const bool normals = !mesh.normals.empty(), colours = !mesh.colours.empty();
    THIXO_ASSERT(!normals || mesh.normals.size() == mesh.vertices.size(), "a mesh needs as many normals as vertices");
    THIXO_ASSERT(!colours || mesh.colours.size() == mesh.vertices.size(), "a mesh needs as many colours as vertices");
    const bool uvs = !mesh.uvs.empty();
    THIXO_ASSERT(!uvs || mesh.uvs.size() == mesh.triangles.size(), "a mesh needs uvs of every triangle");
    std::string out = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.vertices.size());
    out += "property float x\nproperty float y\nproperty float z\n";
    if (normals) out += "property float nx\nproperty float ny\nproperty float nz\n";
    if (colours) out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    out += fmt::format("element face {}\nproperty list uchar int vertex_indices\n{}end_header\n", mesh.triangles.size(),
                       uvs ? "property list uchar float texcoord\n" : "");
    out.reserve(out.size() + mesh.vertices.size() * 27 + mesh.triangles.size() * (uvs ? 38 : 13));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        append(out, mesh.vertices[i].data(), 12);
        if (normals) append(out, mesh.normals[i].data(), 12);
        if (colours)
            for (int k = 0; k < 3; ++k)
                out.push_back(static_cast<char>(std::lround(255 * srgb_from_linear(mesh.colours[i][k]))));
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        out.push_back(3);
        append(out, mesh.triangles[i].data(), 12);
        if (!uvs) continue;
        out.push_back(6);
        for (const Vec2f& uv : mesh.uvs[i]) append(out, uv.data(), 8);
    }
    return out;
}

}  // namespace thixo
