// A triangle mesh as a shape.
#include <cmath>

#include "pipeline/base/log.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/vertex_normals.h"

namespace thixo {
namespace {

struct Mesh final : Shape::Node {
    Mesh(std::shared_ptr<const MeshQuery> q, bool closed_)
        : query(std::move(q)), box(query->bounds()), closed(closed_) {}

    Real distance(const Vec3& x) const override {
        return inside(x) ? -query->closest(x).distance : query->closest(x).distance;
    }

    /// Each point starts from the triangle of the one before it, and keeps its sign where no surface can lie between
    /// the two. (Across a hole the sign changes far from any surface.)
    void distances(const Vec3* x, Real* out, std::size_t n) const override {
        Index near = kNone;
        for (std::size_t k = 0; k < n; ++k) {
            const auto closest = query->closest(x[k], near);
            near = closest.triangle;
            const bool same_side = closed && k > 0 && std::abs(out[k - 1]) > Real(1.0001) * (x[k] - x[k - 1]).norm();
            out[k] = (same_side ? out[k - 1] < 0 : inside(x[k])) ? -closest.distance : closest.distance;
        }
    }
    /// Out of the box nothing is inside, whatever a hole does to the winding number.
    bool inside(const Vec3& x) const { return distance_to(box, x) == 0 && query->inside(x); }
    std::optional<Box3> bounds() const override { return box; }
    std::optional<TriangleMesh> exact_mesh(int) const override {
        TriangleMesh mesh = query->mesh();
        if (mesh.normals.size() != mesh.vertices.size()) add_vertex_normals(mesh);
        return mesh;
    }
    /// Of the closest triangle's corners.
    std::optional<Vec3f> colour(const Vec3& x) const override {
        const TriangleMesh& mesh = query->mesh();
        if (mesh.colours.size() != mesh.vertices.size()) return std::nullopt;
        const auto closest = query->closest(x);
        const auto& corner = mesh.triangles[closest.triangle];
        const Vec3f p = closest.point.cast<float>(), &a = mesh.vertices[corner[0]], &b = mesh.vertices[corner[1]],
                    &c = mesh.vertices[corner[2]];
        const Vec3f n = (b - a).cross(c - a);
        const float v = n.dot((c - a).cross(a - p)) / n.squaredNorm(), w = n.dot((a - p).cross(b - a)) / n.squaredNorm();
        return Vec3f((1 - v - w) * mesh.colours[corner[0]] + v * mesh.colours[corner[1]] + w * mesh.colours[corner[2]]);
    }
    std::shared_ptr<const MeshQuery> query;
    Box3 box;
    bool closed;
};

}  // namespace

Shape mesh_shape(TriangleMesh mesh) {
    const MeshReport report = inspect_mesh(mesh);
    if (report.inside_out) {
        log_warning("mesh is inside out (its signed volume is negative); its triangles are turned round");
        flip_mesh(mesh);
    }
    return Shape(std::make_shared<Mesh>(std::make_shared<const MeshQuery>(std::move(mesh)), report.closed));
}

Shape mesh_shape(std::shared_ptr<const MeshQuery> query) {
    const bool closed = inspect_mesh(query->mesh()).closed;
    return Shape(std::make_shared<Mesh>(std::move(query), closed));
}

}  // namespace thixo
