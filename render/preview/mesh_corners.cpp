#include "render/preview/mesh_corners.h"

#include <algorithm>

#include "pipeline/geometry/mesh_repair.h"

namespace thixo::preview {

namespace {

constexpr float kCrease = 0.766f;  // cos 40 degrees

std::array<float, 4> packed(const Vec3f& x, float w) { return {x.x(), x.y(), x.z(), w}; }

// Faces around each vertex: faces[first[v]] to faces[first[v + 1]].
struct Fans {
    std::vector<Index> first, faces;
};

Fans fans_of(const TriangleMesh& mesh) {
    Fans fans;
    fans.first.assign(mesh.vertices.size() + 1, 0);
    for (const auto& t : mesh.triangles)
        for (const Index v : t) ++fans.first[v + 1];
    for (std::size_t v = 1; v < fans.first.size(); ++v) fans.first[v] += fans.first[v - 1];
    fans.faces.resize(3 * mesh.triangles.size());
    std::vector<Index> next(fans.first.begin(), fans.first.end() - 1);
    for (Index f = 0; f < mesh.triangles.size(); ++f)
        for (const Index v : mesh.triangles[f]) fans.faces[next[v]++] = f;
    return fans;
}

Vec3f corner_normal(const std::vector<Vec3f>& area, const Fans& fans, Index face, Index vertex) {
    const Vec3f own = area[face].normalized();
    Vec3f sum = area[face];
    for (Index k = fans.first[vertex]; k < fans.first[vertex + 1]; ++k) {
        const Vec3f& other = area[fans.faces[k]];
        if (fans.faces[k] != face && own.dot(other) > kCrease * other.norm()) sum += other;
    }
    return sum.normalized();
}

// True where the edge (a, b) of `face` is to be drawn. An edge that two faces share is left to the one with the lower
// number.
bool draws_edge(const TriangleMesh& mesh, const std::vector<Vec3f>& area, const Fans& fans, Index face, Index a,
                Index b) {
    const Vec3f own = area[face].normalized();
    bool shared = false, crease = false, first = true;
    for (Index k = fans.first[a]; k < fans.first[a + 1]; ++k) {
        const Index other = fans.faces[k];
        const auto& t = mesh.triangles[other];
        if (other == face || std::find(t.begin(), t.end(), b) == t.end()) continue;
        shared = true;
        if (other < face) first = false;
        if (own.dot(area[other]) < kCrease * area[other].norm()) crease = true;
    }
    return first && (!shared || crease);
}

}  // namespace

MeshCorners mesh_corners(const TriangleMesh& input) {
    const TriangleMesh mesh = welded(input);
    std::vector<Vec3f> area;
    area.reserve(mesh.triangles.size());
    for (const auto& [a, b, c] : mesh.triangles)
        area.push_back((mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]));
    const Fans fans = fans_of(mesh);
    MeshCorners corners;
    for (Index f = 0; f < mesh.triangles.size(); ++f) {
        const auto& t = mesh.triangles[f];
        if (!(area[f].squaredNorm() > 0)) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const Index a = t[k], b = t[(k + 1) % 3];
            corners.positions.push_back(packed(mesh.vertices[a], 1));
            corners.normals.push_back(packed(corner_normal(area, fans, f, a), 0));
            if (!draws_edge(mesh, area, fans, f, a, b)) continue;
            corners.lines.push_back(packed(mesh.vertices[a], 1));
            corners.lines.push_back(packed(mesh.vertices[b], 1));
        }
    }
    return corners;
}

}  // namespace thixo::preview
