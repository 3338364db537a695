// A triangle mesh as a shape.
#include "pipeline/base/log.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/vertex_normals.h"

namespace thixo {
namespace {

struct Mesh final : Shape::Node {
    explicit Mesh(std::shared_ptr<const MeshQuery> q) : query(std::move(q)), box(query->bounds()) {}
    Real distance(const Vec3& x) const override {
        const Real d = query->closest(x).distance;
        // Out of the box nothing is inside, whatever a hole does to the winding number.
        return distance_to(box, x) == 0 && query->inside(x) ? -d : d;
    }
    std::optional<Box3> bounds() const override { return box; }
    std::optional<TriangleMesh> exact_mesh(int) const override {
        TriangleMesh mesh = query->mesh();
        if (mesh.normals.size() != mesh.vertices.size()) add_vertex_normals(mesh);
        return mesh;
    }
    std::shared_ptr<const MeshQuery> query;
    Box3 box;
};

}  // namespace

Shape mesh_shape(TriangleMesh mesh) {
    if (inspect_mesh(mesh).inside_out) {
        log_warning("mesh is inside out (its signed volume is negative); its triangles are turned round");
        flip_mesh(mesh);
    }
    return mesh_shape(std::make_shared<const MeshQuery>(std::move(mesh)));
}

Shape mesh_shape(std::shared_ptr<const MeshQuery> query) { return Shape(std::make_shared<Mesh>(std::move(query))); }

}  // namespace thixo
