#include "pipeline/geometry/polygon.h"

#include <algorithm>
#include <vector>

namespace thixo {
namespace {

/// Beyond this many corners a fan is made. Cutting ears would cost too much, because each may test all corners.
constexpr std::size_t kMaxEars = 1000;

Vec3d newell_normal(const std::vector<Vec3d>& p) {
    Vec3d n = Vec3d::Zero();
    for (std::size_t k = 0; k < p.size(); ++k) n += (p[k] - p[0]).cross(p[(k + 1) % p.size()] - p[0]);
    return n;
}

bool holds(const Vec3d& n, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p) {
    return n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 && n.dot((a - c).cross(p - c)) >= 0;
}

bool is_ear(const std::vector<Vec3d>& p, const Vec3d& n, std::size_t i) {
    const std::size_t size = p.size(), h = (i + size - 1) % size, j = (i + 1) % size;
    if (!(n.dot((p[i] - p[h]).cross(p[j] - p[h])) > 0)) return false;
    for (std::size_t k = 0; k < size; ++k)
        if (k != h && k != i && k != j && p[k] != p[h] && p[k] != p[j] && holds(n, p[h], p[i], p[j], p[k]))
            return false;
    return true;
}

}  // namespace

void add_polygon(TriangleMesh& mesh, std::span<const Index> corners) {
    std::vector<Index> left;
    for (const Index v : corners)
        if (left.empty() || left.back() != v) left.push_back(v);
    while (left.size() > 1 && left.front() == left.back()) left.pop_back();
    if (left.size() == 3) mesh.triangles.push_back({left[0], left[1], left[2]});
    if (left.size() <= 3) return;

    std::vector<Vec3d> p;
    for (const Index v : left) p.push_back(mesh.vertices[v].cast<double>());
    const Vec3d n = newell_normal(p);
    for (std::size_t i = 1; left.size() > 3 && left.size() <= kMaxEars;) {
        std::size_t tried = 0;
        while (tried < left.size() && !is_ear(p, n, i % left.size())) ++i, ++tried;
        if (tried == left.size()) break;
        i %= left.size();
        const std::size_t size = left.size();
        mesh.triangles.push_back({left[(i + size - 1) % size], left[i], left[(i + 1) % size]});
        left.erase(left.begin() + i);
        p.erase(p.begin() + i);
        i %= left.size();  // continues after the cut, which spreads the ears over the polygon
        ++i;
    }
    for (std::size_t k = 2; k < left.size(); ++k) mesh.triangles.push_back({left[0], left[k - 1], left[k]});
}

void add_polygon(TriangleMesh& mesh, std::span<const Index> corners, std::span<const Vec2f> uvs) {
    const std::size_t before = mesh.triangles.size();
    add_polygon(mesh, corners);
    for (std::size_t k = before; k < mesh.triangles.size(); ++k) {
        std::array<Vec2f, 3>& of = mesh.uvs.emplace_back();
        for (std::size_t c = 0; c < 3; ++c)
            of[c] = uvs[std::size_t(std::find(corners.begin(), corners.end(), mesh.triangles[k][c]) - corners.begin())];
    }
}

void PolygonList::add(std::span<const Index> corners, std::span<const Vec2f> uvs) {
    corners_.insert(corners_.end(), corners.begin(), corners.end());
    if (uvs.size() == corners.size()) uvs_.insert(uvs_.end(), uvs.begin(), uvs.end());
    ends_.push_back(corners_.size());
}

void PolygonList::cut_into(TriangleMesh& mesh) const {
    const std::span<const Index> corners(corners_);
    const std::span<const Vec2f> uvs(uvs_);
    const bool textured = uvs.size() == corners.size() && mesh.triangles.empty();
    std::size_t begin = 0;
    for (const std::size_t end : ends_) {
        if (textured)
            add_polygon(mesh, corners.subspan(begin, end - begin), uvs.subspan(begin, end - begin));
        else
            add_polygon(mesh, corners.subspan(begin, end - begin));
        begin = end;
    }
}

}  // namespace thixo
