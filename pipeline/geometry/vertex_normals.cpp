#include "pipeline/geometry/vertex_normals.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace thixo {
namespace {

constexpr double kSmooth = 0.7660444431189780;  // cos 40 degrees

struct Corner {
    Index triangle;
    int side;      // which of its vertices
    Vec3d normal;  // of the triangle, zero without area
    double angle;  // at this corner
};

double angle_between(const Vec3d& a, const Vec3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// The corners of all triangles, in the order of triangles. Those of vertex v stand at [first[v], first[v + 1]).
std::vector<Corner> corners_by_vertex(const TriangleMesh& mesh, std::vector<Index>& first) {
    first.assign(mesh.vertices.size() + 1, 0);
    for (const auto& t : mesh.triangles)
        for (const Index v : t) ++first[v + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Corner> corners(3 * mesh.triangles.size());
    std::vector<Index> next(first.begin(), first.end() - 1);
    for (Index k = 0; k < mesh.triangles.size(); ++k) {
        const auto& t = mesh.triangles[k];
        const Vec3d p[3] = {mesh.vertices[t[0]].cast<double>(), mesh.vertices[t[1]].cast<double>(),
                            mesh.vertices[t[2]].cast<double>()};
        const Vec3d n = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
        for (int side = 0; side < 3; ++side)
            corners[next[t[side]]++] = {k, side, n,
                                        angle_between(p[(side + 1) % 3] - p[side], p[(side + 2) % 3] - p[side])};
    }
    return corners;
}

}  // namespace

void add_vertex_normals(TriangleMesh& mesh) {
    std::vector<Index> first;
    const std::vector<Corner> corners = corners_by_vertex(mesh, first);
    const std::size_t vertices = mesh.vertices.size();
    mesh.normals.assign(vertices, Vec3f::UnitZ());
    std::vector<Index> group;
    for (std::size_t v = 0; v < vertices; ++v) {
        const Corner* at = corners.data() + first[v];
        const Index n = first[v + 1] - first[v];
        // Corners that angles below the limit join make a group. The first group keeps the vertex.
        group.resize(n);
        std::iota(group.begin(), group.end(), Index(0));
        for (Index i = 0; i < n; ++i)
            for (Index j = 0; j < i; ++j)
                if (group[i] != group[j] && at[i].normal.dot(at[j].normal) > kSmooth)
                    std::replace(group.begin(), group.begin() + i + 1, std::max(group[i], group[j]),
                                 std::min(group[i], group[j]));
        for (Index g = 0; g < n; ++g) {
            if (group[g] != g) continue;
            Vec3d sum = Vec3d::Zero();
            for (Index i = g; i < n; ++i)
                if (group[i] == g) sum += at[i].angle * at[i].normal;
            Index target = static_cast<Index>(v);
            if (g > 0) {
                target = static_cast<Index>(mesh.vertices.size());
                mesh.vertices.push_back(Vec3f(mesh.vertices[v]));
                mesh.normals.push_back(Vec3f::UnitZ());
                if (mesh.colours.size() + 1 == mesh.vertices.size()) mesh.colours.push_back(Vec3f(mesh.colours[v]));
            }
            if (sum.norm() > 0) mesh.normals[target] = sum.normalized().cast<float>();
            for (Index i = g; i < n; ++i)
                if (group[i] == g) mesh.triangles[at[i].triangle][at[i].side] = target;
        }
    }
}

bool has_normals(const TriangleMesh& mesh) {
    return mesh.normals.size() == mesh.vertices.size() &&
           std::ranges::all_of(mesh.normals, [](const Vec3f& n) { return n.squaredNorm() > 0; });
}

}  // namespace thixo
