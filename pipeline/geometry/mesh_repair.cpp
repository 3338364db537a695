#include "pipeline/geometry/mesh_repair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace thixo {
namespace {

struct Edge {
    Index low, high;
    bool forward;
    bool operator<(const Edge& e) const { return low != e.low ? low < e.low : high < e.high; }
};

void count_edges(const TriangleMesh& mesh, const std::vector<Index>& number, MeshReport& report) {
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (const auto& t : mesh.triangles) {
        const Index v[3] = {number[t[0]], number[t[1]], number[t[2]]};
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
        for (int k = 0; k < 3; ++k) {
            const Index a = v[k], b = v[(k + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), a < b});
        }
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t begin = 0, end; begin < edges.size(); begin = end) {
        std::size_t forward = 0;
        for (end = begin; end < edges.size() && !(edges[begin] < edges[end]); ++end) forward += edges[end].forward;
        if (end - begin == 1)
            ++report.open_edges;
        else if (end - begin != 2 || forward != 1)
            ++report.bad_edges;
    }
}

}  // namespace

std::vector<Index> position_numbers(const std::vector<Vec3f>& vertices, Index& count) {
    std::vector<Index> order(vertices.size()), number(vertices.size());
    std::iota(order.begin(), order.end(), Index(0));
    const auto key = [&](Index i) {
        return std::array<float, 3>{vertices[i].x() + 0.f, vertices[i].y() + 0.f, vertices[i].z() + 0.f};
    };
    std::sort(order.begin(), order.end(), [&](Index a, Index b) {
        const auto ka = key(a), kb = key(b);
        return ka != kb ? ka < kb : a < b;
    });
    std::vector<Index> first(vertices.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        first[order[k]] = k > 0 && key(order[k]) == key(order[k - 1]) ? first[order[k - 1]] : order[k];
    count = 0;
    for (Index i = 0; i < vertices.size(); ++i) number[i] = first[i] == i ? count++ : number[first[i]];
    return number;
}

MeshReport inspect_mesh(const TriangleMesh& mesh) {
    MeshReport report;
    report.vertices = mesh.vertices.size();
    report.triangles = mesh.triangles.size();
    if (mesh.vertices.empty()) return report;
    Vec3f lower = mesh.vertices[0], upper = lower;
    for (const Vec3f& v : mesh.vertices) lower = lower.cwiseMin(v), upper = upper.cwiseMax(v);
    report.bounds = {lower.cast<Real>(), upper.cast<Real>()};

    Index positions;
    const std::vector<Index> number = position_numbers(mesh.vertices, positions);
    count_edges(mesh, number, report);
    const Vec3d centre = (lower.cast<double>() + upper.cast<double>()) / 2;  // keeps the volume of a far-off mesh exact
    for (const auto& t : mesh.triangles) {
        const Vec3d a = mesh.vertices[t[0]].cast<double>() - centre, b = mesh.vertices[t[1]].cast<double>() - centre,
                    c = mesh.vertices[t[2]].cast<double>() - centre;
        report.volume += a.dot(b.cross(c)) / 6;
        if (!((b - a).cross(c - a).squaredNorm() > 0)) ++report.degenerate_triangles;
    }
    report.void_normals = static_cast<std::size_t>(
        std::ranges::count_if(mesh.normals, [](const Vec3f& n) { return !(n.squaredNorm() > 0); }));
    report.closed = !mesh.triangles.empty() && report.open_edges == 0 && report.bad_edges == 0;
    return report;
}

TriangleMesh welded(const TriangleMesh& mesh) {
    Index count;
    const std::vector<Index> number = position_numbers(mesh.vertices, count);
    TriangleMesh out;
    out.vertices.resize(count);
    for (std::size_t i = 0; i < number.size(); ++i) out.vertices[number[i]] = mesh.vertices[i];
    for (const auto& t : mesh.triangles) out.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    return out;
}

void transform_mesh(TriangleMesh& mesh, double factor, const Quatd& rotation, const Vec3d& translation) {
    const Mat3d turn = rotation.toRotationMatrix();
    for (Vec3f& v : mesh.vertices) v = (factor * (turn * v.cast<double>()) + translation).cast<float>();
    for (Vec3f& n : mesh.normals) n = (turn * n.cast<double>()).cast<float>();
}

void turn_triangle(TriangleMesh& mesh, std::size_t k) {
    std::swap(mesh.triangles[k][1], mesh.triangles[k][2]);
    if (!mesh.uvs.empty()) std::swap(mesh.uvs[k][1], mesh.uvs[k][2]);
}

void flip_mesh(TriangleMesh& mesh) {
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) turn_triangle(mesh, k);
    for (Vec3f& n : mesh.normals) n = -n;
}

}  // namespace thixo
