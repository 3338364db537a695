#include "pipeline/geometry/sharp_edges.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace thixo {
namespace {

constexpr float kSmooth = 0.76604444f;  // cos 40 degrees
constexpr double kFlat = 0.1;           // of the largest eigenvalue: a direction in which the planes tell no place
constexpr int kNewtonSteps = 3;         // from tangent planes, 0.1 cells off at most: to rounding

bool sharp(const Vec3f& a, const Vec3f& b) { return a.dot(b) < kSmooth; }

Vec3f area_normal(const Vec3f& a, const Vec3f& b, const Vec3f& c) { return (b - a).cross(c - a); }

/// Planes near a place, and the shortest way from there to where they meet by least squares.
struct Planes {
    Mat3d normals = Mat3d::Zero();  // sum of n n^T
    Vec3d ahead = Vec3d::Zero();    // [m] sum of n distance

    /// The plane is `distance` [m] away from the place, along n.
    void add(const Vec3f& n, double distance) {
        normals += n.cast<double>() * n.cast<double>().transpose();
        ahead += distance * n.cast<double>();
    }
    Vec3f meet() const {
        const Eigen::SelfAdjointEigenSolver<Mat3d> modes(normals);
        Vec3d move = Vec3d::Zero();
        for (int k = 0; k < 3; ++k) {
            const Vec3d mode = modes.eigenvectors().col(k);
            if (modes.eigenvalues()[k] > kFlat * modes.eigenvalues()[2])
                move += mode * (mode.dot(ahead) / modes.eigenvalues()[k]);
        }
        return move.cast<float>();
    }
};

/// Two triangles side by side: `left` has the directed segment from -> to, `right` the opposite one.
struct Segment {
    Index from, to;
    std::size_t left, right;
    Index left_centre, right_centre;
};

/// Segments between two fans whose centres are on edges, where the segment itself crosses an edge.
std::vector<Segment> segments_across(const TriangleMesh& mesh, const std::vector<char>& on_edge) {
    std::map<std::pair<Index, Index>, std::size_t> begun;  // directed segments by the triangle that has them
    std::vector<Segment> across;
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
        const auto& [centre, from, to] = mesh.triangles[k];
        if (!on_edge[centre] || !sharp(mesh.normals[from], mesh.normals[to])) continue;
        if (const auto other = begun.find({to, from}); other != begun.end())
            across.push_back({to, from, other->second, k, mesh.triangles[other->second][0], centre});
        else
            begun[{from, to}] = k;
    }
    return across;
}

/// Whether one of the two triangles beside the line between the centres is turned against its face. Centres that all but
/// coincide make triangles without area, which are neither.
bool folds(const TriangleMesh& mesh, const Segment& s) {
    const auto turned = [&](Index before, Index on_grid, Index after) {
        const Vec3f n = area_normal(mesh.vertices[before], mesh.vertices[on_grid], mesh.vertices[after]);
        return n.dot(mesh.normals[on_grid]) < -0.05f * (mesh.vertices[s.to] - mesh.vertices[s.from]).squaredNorm();
    };
    return turned(s.left_centre, s.from, s.right_centre) || turned(s.right_centre, s.to, s.left_centre);
}

/// Copies of a centre with the normals of the faces that meet there.
struct Copy {
    Index vertex;
    Vec3f normal, sum;
};

/// Mean normal of the triangle's vertices on grid edges: those know one face each.
Vec3f side_of(const TriangleMesh& mesh, const std::vector<char>& on_edge, const std::array<Index, 3>& triangle) {
    Vec3f sum = Vec3f::Zero();
    for (const Index v : triangle)
        if (!on_edge[v]) sum += mesh.normals[v];
    return sum.stableNormalized();
}

}  // namespace

SmoothFaces::SmoothFaces(const Shape& shape, double cell)
    : tree_(without_differences(faces_of(shape))), faces_(number_faces(tree_)), step_(static_cast<Real>(0.05 * cell)) {}

std::size_t SmoothFaces::nearest(const Vec3f& x) const {
    if (faces_.size() == 1) return 0;
    std::vector<Real> d;
    for (const Shape& face : faces_) d.push_back(face.distance(x.cast<Real>()));
    std::vector<std::size_t> order(faces_.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](std::size_t face) { return std::abs(d[face]); });
    const auto bounds = [&](std::size_t face) {
        return bounds_solid(tree_, static_cast<int>(face), step_ / 5,
                            [&](int other) { return d[static_cast<std::size_t>(other)]; });
    };
    const auto found = std::ranges::find_if(order, bounds);
    return found == order.end() ? order[0] : *found;
}

Vec3f SmoothFaces::normal(std::size_t face, const Vec3f& x) const {
    return faces_[face].gradient(x.cast<Real>(), step_).cast<float>();
}

bool crosses_edge(const TriangleMesh& mesh, const std::vector<Index>& loop) {
    for (std::size_t i = 0; i < loop.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            if (sharp(mesh.normals[loop[i]], mesh.normals[loop[k]])) return true;
    return false;
}

std::optional<Vec3f> point_on_edge(const SmoothFaces& faces, const TriangleMesh& mesh, const Fan& fan, double cell) {
    const Vec3f& centre = mesh.vertices[fan.centre];
    Planes tangents;
    std::set<std::size_t> meeting;
    for (const Index v : fan.loop) {
        tangents.add(mesh.normals[v], mesh.normals[v].dot(mesh.vertices[v] - centre));
        meeting.insert(faces.nearest(mesh.vertices[v]));
    }
    Vec3f place = centre + tangents.meet();
    for (int i = 0; i < kNewtonSteps; ++i) {
        Planes here;
        for (const std::size_t face : meeting) here.add(faces.normal(face, place), -faces.distance(face, place));
        place += here.meet();
    }
    if (!((place - centre).norm() < std::sqrt(3.0) * cell)) return std::nullopt;
    for (std::size_t i = 0; i < fan.loop.size(); ++i) {
        const Index a = fan.loop[i], b = fan.loop[(i + 1) % fan.loop.size()];
        if (sharp(mesh.normals[a], mesh.normals[b])) continue;
        const Vec3f n = area_normal(place, mesh.vertices[a], mesh.vertices[b]);
        if (n.dot(mesh.normals[a] + mesh.normals[b]) < 0) return std::nullopt;
    }
    return place;
}

void keep_edges_sharp(TriangleMesh& mesh, const std::vector<Fan>& fans) {
    std::vector<char> on_edge(mesh.vertices.size(), 0);
    for (const Fan& fan : fans) on_edge[fan.centre] = fan.on_edge;
    std::set<std::pair<Index, Index>> joined;  // two centres may share two segments, but have one line between them
    for (const Segment& s : segments_across(mesh, on_edge)) {
        if (folds(mesh, s) || !joined.insert(std::minmax({s.left_centre, s.right_centre})).second) continue;
        mesh.triangles[s.left] = {s.left_centre, s.from, s.right_centre};
        mesh.triangles[s.right] = {s.right_centre, s.to, s.left_centre};
    }
    std::map<Index, std::vector<Copy>> copies;
    for (auto& triangle : mesh.triangles) {
        const Vec3f side = side_of(mesh, on_edge, triangle);
        for (Index& v : triangle) {
            if (v >= on_edge.size() || !on_edge[v]) continue;
            std::vector<Copy>& of = copies[v];
            auto copy = std::ranges::find_if(of, [&](const Copy& c) { return !sharp(c.normal, side); });
            if (copy == of.end()) {
                Index vertex = v;
                if (!of.empty()) {
                    vertex = static_cast<Index>(mesh.vertices.size());
                    mesh.vertices.push_back(Vec3f(mesh.vertices[v]));
                    mesh.normals.push_back(side);
                }
                copy = of.insert(of.end(), {vertex, side, Vec3f::Zero()});
            }
            copy->sum += side;
            v = copy->vertex;
        }
    }
    for (const auto& [centre, of] : copies)
        for (const Copy& copy : of) mesh.normals[copy.vertex] = copy.sum.stableNormalized();
}

}  // namespace thixo
