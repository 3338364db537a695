#include "sim/stage/boundary_mesh.h"

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/tessellate.h"
#include "sim/space/scene_shapes.h"

namespace thixo {
namespace {

constexpr double kPlaneExtent = 200;  // m, edge of the square a plane is drawn as

std::optional<TriangleMesh> tessellated(const scene::Scene& scene, const scene::Boundary& b) {
    if (const auto* p = std::get_if<scene::Plane>(&b.shape.kind)) {
        const Vec3d n = p->normal.normalized();
        const Quatd turn = rotation_from_degrees(b.shape.rotate);
        const Vec3d on = turn * Vec3d(b.shape.scale * p->offset * n) + b.shape.translate + b.shape.offset * (turn * n);
        return tessellate_plane(on, b.inside ? Vec3d(-(turn * n)) : Vec3d(turn * n), kPlaneExtent);
    }
    const Shape shape = make_shape(scene, b.shape);
    if (!shape.bounds()) {
        log_warning(
            "boundary '{}' has no bounds and is not drawn; intersect its shape with a box, or set visible: false",
            b.name);
        return std::nullopt;
    }
    TriangleMesh mesh = tessellate(shape, scene.solver.spacing / 2);
    if (b.inside) flip_mesh(mesh);
    return mesh;
}

bool mapped_by_uv(const scene::Look& look, const scene::Boundary& b) {
    const std::string& name = b.look.empty() ? b.name : b.look;
    return std::ranges::any_of(look.appearances, [&](const scene::Appearance& a) {
        return a.name == name && !a.image.file.empty() && a.image.mapping == scene::Mapping::uv;
    });
}

}  // namespace

std::optional<TriangleMesh> boundary_mesh(const scene::Scene& scene, const scene::Boundary& boundary) {
    std::optional<TriangleMesh> mesh;
    try {
        mesh = tessellated(scene, boundary);
    } catch (const InputError& error) {
        const std::string place = boundary.shape.where, said = error.what();
        if (said.starts_with(place)) throw;
        throw InputError("{}: boundary '{}' cannot be drawn: {}; or set visible: false", place, boundary.name, said);
    }
    if (mesh && mesh->uvs.empty() && mapped_by_uv(scene.look, boundary))
        throw InputError(
            "{}: the mesh of boundary '{}' has no texture coordinates, by which its appearance maps an image; write "
            "mapping: planar, box or cylinder",
            boundary.shape.where, boundary.name);
    return mesh;
}

}  // namespace thixo
