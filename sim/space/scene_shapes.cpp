#include "sim/space/scene_shapes.h"

#include <map>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/scene_origin.h"
#include "pipeline/contract/scene_walk.h"
#include "pipeline/geometry/key_motion.h"
#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/mesh_orientation.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/point_surfels.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

constexpr int kDeepest = 64;  // of shapes within shapes

class ShapeBuilder {
  public:
    explicit ShapeBuilder(const scene::Scene& scene) : scene_(scene) {}

    Shape build(const scene::Shape& source, int depth) const {
        if (depth > kDeepest)
            throw InputError("{}: shapes are nested more than {} deep, or a named shape contains itself", source.where,
                             kDeepest);
        Shape shape = std::visit([&](const auto& kind) { return make(kind, source, depth); }, source.kind);
        const bool moved = source.scale != 1 || !source.rotate.isZero() || !source.translate.isZero();
        if (moved) shape = transformed(shape, source.scale, rotation_from_degrees(source.rotate), source.translate);
        if (source.offset != 0) shape = offset(shape, source.offset);
        if (source.shell > 0) shape = shell(shape, source.shell);
        return shape;
    }

  private:
    static Shape make(const std::monostate&, const scene::Shape& source, int) {
        throw InputError("{}: a shape of no kind", source.where);
    }
    static Shape make(const scene::Sphere& k, const scene::Shape&, int) { return sphere(k.radius); }
    static Shape make(const scene::Ellipsoid& k, const scene::Shape&, int) { return ellipsoid(k.radii); }
    static Shape make(const scene::BoxShape& k, const scene::Shape&, int) { return box(k.size, k.rounding); }
    static Shape make(const scene::Cylinder& k, const scene::Shape&, int) {
        return cylinder(k.radius, k.height, k.rounding);
    }
    static Shape make(const scene::RoundedCone& k, const scene::Shape&, int) {
        return rounded_cone(k.radius1, k.radius2, k.height);
    }
    static Shape make(const scene::Capsule& k, const scene::Shape&, int) { return capsule(k.from, k.to, k.radius); }
    static Shape make(const scene::Torus& k, const scene::Shape&, int) { return torus(k.radius, k.tube); }
    static Shape make(const scene::Plane& k, const scene::Shape&, int) { return plane(k.normal, k.offset); }
    static Shape make(const scene::Revolve& k, const scene::Shape&, int) { return revolve(k.profile); }
    static Shape make(const scene::MeshFile& k, const scene::Shape& source, int) {
        Vec3d origin;
        TriangleMesh mesh = read_mesh(k.file, &origin);
        const MeshReport report = inspect_mesh(mesh);
        if (report.triangles == 0 && mesh.normals.empty())
            throw InputError("{}: mesh {} has neither triangles nor points with normals", source.where, k.file);
        const double extent = static_cast<double>(report.bounds.upper.z() - report.bounds.lower.z());
        if (k.scale <= 0 && !(extent > 0))
            throw InputError("{}: mesh {} is flat along z; give scale instead of height", source.where, k.file);
        const double scale = k.scale > 0 ? k.scale : k.height / extent;
        const Vec3d to_origin = k.place == scene::Place::file ? Vec3d(-origin) : middle_or_base(report.bounds, k.place);
        transform_mesh(mesh, scale, Quatd::Identity(), k.shift - scale * to_origin);
        try {
            return report.triangles == 0 ? point_shape(std::move(mesh)) : mesh_shape(std::move(mesh));
        } catch (const InputError& error) {
            throw InputError("{}: mesh {}: {}", source.where, k.file, error.what());
        }
    }
    static Vec3d middle_or_base(const Box3& box, scene::Place place) {
        Vec3d at = (0.5 * (box.lower + box.upper)).cast<double>();
        if (place == scene::Place::base) at.z() = static_cast<double>(box.lower.z());
        return at;
    }
    static Shape make(const scene::Sweep& k, const scene::Shape&, int) {
        std::vector<SweepPoint> points;
        for (const scene::SweepPoint& p : k.points) points.push_back({p.at, p.radius});
        return swept(points, k.closed);
    }
    Shape make(const scene::Union& k, const scene::Shape&, int depth) const {
        return union_of(children(k, depth), k.smooth);
    }
    Shape make(const scene::Intersection& k, const scene::Shape&, int depth) const {
        return intersection_of(children(k, depth), k.smooth);
    }
    Shape make(const scene::Difference& k, const scene::Shape&, int depth) const {
        return difference_of(children(k, depth), k.smooth);
    }
    Shape make(const scene::Mirror& k, const scene::Shape&, int depth) const {
        return mirrored(together(k, depth), k.normal, k.offset, k.smooth);
    }
    Shape make(const scene::Repeat& k, const scene::Shape&, int depth) const {
        return repeated(together(k, depth), k.count, k.step, k.turn, k.smooth);
    }
    Shape make(const scene::Twist& k, const scene::Shape&, int depth) const {
        return twisted(together(k, depth), k.rate);
    }
    Shape make(const scene::Bend& k, const scene::Shape&, int depth) const { return bent(together(k, depth), k.angle); }
    Shape make(const scene::Noise& k, const scene::Shape&, int depth) const {
        return roughened(together(k, depth), k.amplitude, k.scale, k.octaves);
    }
    Shape make(const scene::NamedShape& k, const scene::Shape& source, int depth) const {
        for (const auto& [name, shape] : scene_.shapes)
            if (name == k.name) return build(shape, depth + 1);
        throw InputError("{}: there is no shape named '{}' in `shapes`", source.where, k.name);
    }
    /// The shapes of a list as one.
    Shape together(const scene::ShapeList& list, int depth) const {
        return union_of(children(list, depth), list.smooth);
    }
    std::vector<Shape> children(const scene::ShapeList& list, int depth) const {
        std::vector<Shape> shapes;
        for (const scene::Shape& source : list.shapes) shapes.push_back(build(source, depth + 1));
        return shapes;
    }

    const scene::Scene& scene_;
};

void warn_of_triangles(TriangleMesh& mesh, const std::string& name) {
    const std::size_t turned = orient_outward(mesh);
    const MeshReport report = inspect_mesh(mesh);
    if (turned == report.triangles)
        log_warning("{} is inside out (its signed volume is negative); its triangles are turned round", name);
    else if (turned > 0)
        log_warning(
            "{}: {} of {} triangles are wound against those beside them, or belong to a shell that is inside out; "
            "they are turned round",
            name, turned, report.triangles);
    if (!report.closed)
        log_warning(
            "{} is not closed ({} open edges, {} where more than two triangles meet or two contradict each other); "
            "its inside is taken by winding number: close it where the body comes out wrong",
            name, report.open_edges, report.bad_edges);
    if (report.void_normals > 0)
        log_warning("{} has {} normals without a length; none of its normals are used", name, report.void_normals);
}

void warn_of_points(const TriangleMesh& points, const std::string& name) {
    if (points.normals.empty()) return;  // refused where the shape is made
    try {
        PointSurfels surfels = surfels_of_points(points);
        if (orient_outward(surfels))
            log_warning("{} has normals that point inward (its signed volume is negative); they are turned round",
                        name);
    } catch (const InputError& error) {
        throw InputError("{}: {}", name, error.what());
    }
}

}  // namespace

void warn_of_meshes(const scene::Scene& scene) {
    std::set<std::string> seen;
    scene::walk_shapes(scene, [&](const scene::Shape& shape, const std::string&) {
        const auto* k = std::get_if<scene::MeshFile>(&shape.kind);
        if (!k || !seen.insert(k->file).second) return;
        Vec3d origin;
        TriangleMesh mesh = read_mesh(k->file, &origin);
        const std::string name = fmt::format("{}: mesh {}", shape.where, k->file);
        mesh.triangles.empty() ? warn_of_points(mesh, name) : warn_of_triangles(mesh, name);
    });
}

Shape make_shape(const scene::Scene& scene, const scene::Shape& shape) { return ShapeBuilder(scene).build(shape, 0); }

Shape wall_solid(const scene::Scene& scene, const scene::Boundary& boundary) {
    Shape shape = make_shape(scene, boundary.shape);
    return boundary.inside ? inverted(shape) : shape;
}

Shape wall_solid_at_rest(const scene::Scene& scene, const scene::Boundary& boundary) {
    Shape solid = wall_solid(scene, boundary);
    if (boundary.motion.empty()) return solid;
    const RigidPose pose = motion_of(scene, boundary.motion).pose(0);
    return transformed(solid, 1, pose.rotation, pose.translation);
}

RigidMotion motion_of(const scene::Scene& scene, const std::vector<scene::Key>& keys) {
    return keys.empty() ? RigidMotion() : motion_along(keys).seen_from(scene.origin);
}

scene::Scene near_origin(const scene::Scene& scene) {
    std::map<std::string, scene::Extent> read;
    const auto extent = [&](const scene::MeshFile& k) {
        const auto [known, fresh] = read.try_emplace(k.file);
        if (fresh) {
            Vec3d origin(0, 0, 0);
            const Box3 box = inspect_mesh(read_mesh(k.file, &origin)).bounds;
            known->second = {origin + box.lower.cast<double>(), origin + box.upper.cast<double>()};
        }
        return known->second;
    };
    return scene::relative_to(scene, scene::origin_for(scene, extent));
}

std::string place_text(const scene::Scene& scene, const Vec3& x) {
    const Vec3d at = x.cast<double>() + scene.origin;
    // Far from the world's origin four digits would name a whole region.
    const int digits = scene.origin.isZero() ? 4 : 12;
    return fmt::format("({:.{}g}, {:.{}g}, {:.{}g})", at.x(), digits, at.y(), digits, at.z(), digits);
}

}  // namespace thixo
