#include "sim/stage/boundary_mesh.h"

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/scene_extent.h"
#include "pipeline/contract/scene_walk.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/tessellate.h"
#include "sim/space/scene_shapes.h"

namespace thixo {
namespace {

constexpr double kPlaneExtent = 200;  // m, edge of the square in the middle of a plane
constexpr int kPlaneRings = 10;       // a million times as wide
constexpr double kAcross = 200;       // cells along an obstacle, at least: it may fill a picture

/// The square is this wide or 4, 16, ... times as wide or narrow. Single precision places a ray's hit to a ten millionth
/// of the triangle that it meets.
double plane_extent(double spacing) {
    double extent = kPlaneExtent;
    while (extent < 2e3 * spacing) extent *= 4;
    while (extent / 4 > 1.28e5 * spacing) extent /= 4;
    return extent;
}

/// The middle of all matter at the start [m].
Vec3d middle_of_matter(const scene::Scene& scene) {
    Vec3d lower = Vec3d::Constant(1e300), upper = -lower;
    const auto add = [&](const Vec3d& x) {
        lower = lower.cwiseMin(x);
        upper = upper.cwiseMax(x);
    };
    for (const scene::Emitter& e : scene.emitters) add(e.position);
    for (const scene::Body& b : scene.bodies)
        if (const auto box = make_shape(scene, b.shape).bounds()) {
            add(box->lower.cast<double>());
            add(box->upper.cast<double>());
        }
    return lower.x() > upper.x() ? Vec3d(0, 0, 0) : Vec3d(0.5 * (lower + upper));
}

/// A plane from horizon to horizon. Its squares lie about its point nearest to the origin. For matter far away they lie
/// a whole number of half squares from there along the axes.
TriangleMesh endless_plane(const scene::Scene& scene, const Vec3d& on, const Vec3d& normal) {
    const double extent = plane_extent(scene.solver.spacing);
    const Vec3d away = (middle_of_matter(scene) - on) / (extent / 2);
    const Vec3d shift = extent / 2 * Vec3d(std::trunc(away.x()), std::trunc(away.y()), std::trunc(away.z()));
    return tessellate_plane(on + shift - normal.dot(shift) * normal, normal, extent, kPlaneRings);
}

/// The colours of meshes that a shape is made of in part; white where it has none there.
void add_colours(const Shape& shape, TriangleMesh& mesh) {
    std::vector<Vec3f> colours;
    bool any = false;
    for (const Vec3f& x : mesh.vertices) {
        const std::optional<Vec3f> colour = shape.node().colour(x.cast<Real>());
        if (!colour && colours.empty() && shape.node().exact_mesh(3)) return;
        any = any || colour;
        colours.push_back(colour.value_or(Vec3f::Ones()));
    }
    if (any) mesh.colours = std::move(colours);
}

/// With cells of half a spacing, or smaller ones: `across` of them along the longest edge.
std::optional<TriangleMesh> tessellated(const scene::Scene& scene, const scene::Boundary& b, double across) {
    if (const auto plane = scene::placed_plane(b.shape))
        return endless_plane(scene, plane->on, b.inside ? Vec3d(-plane->normal) : plane->normal);
    const Shape shape = make_shape(scene, b.shape);
    if (!shape.bounds()) {
        log_warning(
            "boundary '{}' has no bounds and is not drawn; intersect its shape with a box, or set visible: false",
            b.name);
        return std::nullopt;
    }
    const double extent = static_cast<double>((shape.bounds()->upper - shape.bounds()->lower).maxCoeff());
    TriangleMesh mesh = tessellate(shape, std::min(scene.solver.spacing / 2, extent / across));
    if (mesh.colours.empty() && scene::holds_mesh(scene, b.shape)) add_colours(shape, mesh);
    if (b.inside) flip_mesh(mesh);
    return mesh;
}

bool mapped_by_uv(const scene::Look& look, const scene::Boundary& b) {
    const std::string& name = b.look.empty() ? b.name : b.look;
    return std::ranges::any_of(look.appearances, [&](const scene::Appearance& a) {
        return a.name == name && !a.image.file.empty() && a.image.mapping == scene::Mapping::uv;
    });
}

std::optional<TriangleMesh> drawable(const scene::Scene& scene, const scene::Boundary& boundary, double across) {
    std::optional<TriangleMesh> mesh;
    try {
        mesh = tessellated(scene, boundary, across);
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

}  // namespace

std::optional<TriangleMesh> boundary_mesh(const scene::Scene& scene, const scene::Boundary& boundary) {
    return drawable(scene, boundary, kAcross);
}

void require_drawable(const scene::Scene& scene, const scene::Boundary& boundary) {
    try {
        drawable(scene, boundary, 1);
    } catch (const InputError&) {
        drawable(scene, boundary, kAcross);  // what is thinner than half a spacing
    }
}

}  // namespace thixo
