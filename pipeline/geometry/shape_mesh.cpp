// A triangle mesh as a shape.
#include <algorithm>
#include <cmath>

#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/direct_surface.h"
#include "pipeline/geometry/mesh_orientation.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/point_surfels.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/vertex_normals.h"

namespace thixo {
namespace {

/// The triangles with smooth normals, except at edges sharper than 40 degrees.
struct Triangles final : DirectSurface {
    explicit Triangles(std::shared_ptr<const MeshQuery> q) : query(std::move(q)) {
        const TriangleMesh& given = query->mesh();
        if (has_normals(given)) {
            smooth = given;
        } else {
            smooth = welded(given);
            if (given.colours.size() == given.vertices.size()) take_colours(given);
            add_vertex_normals(smooth);
        }
        double sum = 0;
        for (const auto& [a, b, c] : given.triangles) {
            const Vec3d p = given.vertices[a].cast<double>();
            sum += 0.5 * (given.vertices[b].cast<double>() - p).cross(given.vertices[c].cast<double>() - p).norm();
            up_to.push_back(sum);
        }
    }
    double area() const override { return up_to.back(); }
    void point(double u, double v, double w, Vec3& x, Vec3& normal) const override {
        const auto at = std::upper_bound(up_to.begin(), up_to.end(), u * area());
        const std::size_t k = std::min(static_cast<std::size_t>(at - up_to.begin()), up_to.size() - 1);
        if (v + w > 1) {
            v = 1 - v;
            w = 1 - w;
        }
        const auto& t = query->mesh().triangles[k];
        const auto corner = [&](int i) { return query->mesh().vertices[t[std::size_t(i)]].cast<Real>(); };
        x = Real(1 - v - w) * corner(0) + Real(v) * corner(1) + Real(w) * corner(2);
        normal = normal_at(static_cast<Index>(k), Real(v), Real(w));
    }
    void project(Vec3& x, Vec3& normal) const override {
        const auto closest = query->closest(x);
        x = closest.point;
        const Vec2 at = barycentric(query->mesh(), closest.triangle, x);
        normal = normal_at(closest.triangle, at.x(), at.y());
    }
    /// Weights of the second and third corner. They are clamped to the triangle, because slivers magnify rounding
    /// errors.
    static Vec2 barycentric(const TriangleMesh& mesh, Index k, const Vec3& x) {
        const auto& t = mesh.triangles[k];
        const Vec3d a = mesh.vertices[t[0]].cast<double>(), b = mesh.vertices[t[1]].cast<double>(),
                    c = mesh.vertices[t[2]].cast<double>(), at = x.cast<double>();
        const Vec3d n = (b - a).cross(c - a);
        const double scale = 1 / n.squaredNorm();
        const double v = std::clamp(n.dot((c - a).cross(a - at)) * scale, 0.0, 1.0),
                     w = std::clamp(n.dot((a - at).cross(b - a)) * scale, 0.0, 1.0 - v);
        return {static_cast<Real>(v), static_cast<Real>(w)};
    }
    void take_colours(const TriangleMesh& given) {
        smooth.colours.resize(smooth.vertices.size());
        for (std::size_t k = 0; k < given.triangles.size(); ++k)
            for (std::size_t i = 0; i < 3; ++i)
                smooth.colours[smooth.triangles[k][i]] = given.colours[given.triangles[k][i]];
    }
    Vec3 normal_at(Index k, Real v, Real w) const {
        const auto& t = smooth.triangles[k];
        const auto corner = [&](int i) { return smooth.normals[t[std::size_t(i)]].cast<Real>(); };
        const Vec3 n = (1 - v - w) * corner(0) + v * corner(1) + w * corner(2);
        const Real length = n.norm();
        return length > Real(1e-3) ? Vec3(n / length) : corner(0);
    }
    std::shared_ptr<const MeshQuery> query;
    TriangleMesh smooth;        // the same triangles over vertices with normals
    std::vector<double> up_to;  // area of the triangles up to each one
};

struct Mesh final : Shape::Node {
    Mesh(std::shared_ptr<const MeshQuery> q, bool closed_)
        : query(std::move(q)), box(query->bounds()), closed(closed_) {}

    Real distance(const Vec3& x) const override {
        return inside(x) ? -query->closest(x).distance : query->closest(x).distance;
    }

    /// The search for each point starts from the triangle of the point before it. The sign is kept where no surface can
    /// lie between the two. (Across a hole the sign changes far from any surface.)
    void distances(const Vec3* x, Real* out, std::size_t n) const override {
        Index near = kNone;
        for (std::size_t k = 0; k < n; ++k) {
            const auto closest = query->closest(x[k], near);
            near = closest.triangle;
            const bool same_side = closed && k > 0 && std::abs(out[k - 1]) > Real(1.0001) * (x[k] - x[k - 1]).norm();
            out[k] = (same_side ? out[k - 1] < 0 : inside(x[k])) ? -closest.distance : closest.distance;
        }
    }
    /// Outside the box every point is outside, whatever winding number a hole causes there.
    bool inside(const Vec3& x) const { return distance_to(box, x) == 0 && query->inside(x); }
    std::optional<Box3> bounds() const override { return box; }
    std::optional<TriangleMesh> exact_mesh(int) const override {
        TriangleMesh mesh = query->mesh();
        if (!has_normals(mesh)) add_vertex_normals(mesh);
        return mesh;
    }
    /// Interpolates the colours of the closest triangle's corners.
    std::optional<Vec3f> colour(const Vec3& x) const override {
        const TriangleMesh& mesh = query->mesh();
        if (mesh.colours.size() != mesh.vertices.size()) return std::nullopt;
        const auto closest = query->closest(x);
        const auto& corner = mesh.triangles[closest.triangle];
        const Vec2f at = Triangles::barycentric(mesh, closest.triangle, closest.point).cast<float>();
        const float v = at.x(), w = at.y();
        return Vec3f((1 - v - w) * mesh.colours[corner[0]] + v * mesh.colours[corner[1]] + w * mesh.colours[corner[2]]);
    }
    std::shared_ptr<const DirectSurface> direct_surface() const override { return std::make_shared<Triangles>(query); }
    std::shared_ptr<const PointSurfels> own_surfels() const override {
        const TriangleMesh smooth = Triangles(query).smooth;
        std::vector<char> used(smooth.vertices.size(), 0);
        for (const auto& t : smooth.triangles)
            for (const Index v : t) used[v] = 1;
        TriangleMesh points;
        for (std::size_t v = 0; v < used.size(); ++v) {
            if (!used[v]) continue;
            points.vertices.push_back(smooth.vertices[v]);
            points.normals.push_back(smooth.normals[v]);
            if (!smooth.colours.empty()) points.colours.push_back(smooth.colours[v]);
        }
        return std::make_shared<PointSurfels>(surfels_of_points(points));
    }
    std::shared_ptr<const MeshQuery> query;
    Box3 box;
    bool closed;
};

}  // namespace

Shape mesh_shape(TriangleMesh mesh) {
    orient_outward(mesh);
    return mesh_shape(std::make_shared<const MeshQuery>(std::move(mesh)));
}

Shape mesh_shape(std::shared_ptr<const MeshQuery> query) {
    const bool closed = inspect_mesh(query->mesh()).closed;
    return Shape(std::make_shared<Mesh>(std::move(query), closed));
}

}  // namespace thixo
