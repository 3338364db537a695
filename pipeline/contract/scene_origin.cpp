#include "pipeline/contract/scene_origin.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace thixo::scene {
namespace {

constexpr double kNearSpacings = 1024;  // spacings; a float of this size is good to a sixteen thousandth of a spacing
constexpr double kGain = 4;    // of the matter's own half size: nearer than this, moving it gains less than two bits
constexpr double kStep = 100;  // spacings, the least step of origins
constexpr int kDeepest = 64;   // of shapes within shapes

/// Moves shapes. What can take a shift into its own numbers does: distance functions are of single precision. Taking
/// two large shifts of them away from each other would leave little.
class Mover {
  public:
    /// Named shapes of the scene that move get a copy among its shapes.
    explicit Mover(Scene& scene) : shapes_(scene.shapes) {}

    void move(Shape& s, const Vec3d& by, int depth = 0) {
        const Vec3d shift = s.translate + by;
        const Vec3d own = rotation(s.rotate).transpose() * shift / s.scale;
        if (depth > kDeepest || !std::visit([&](auto& kind) { return take(kind, own, depth); }, s.kind))
            s.translate = shift;
        else
            s.translate.setZero();
    }

  private:
    bool take(MeshFile& k, const Vec3d& by, int) {
        k.shift += by;
        return true;
    }
    bool take(Capsule& k, const Vec3d& by, int) {
        k.from += by;
        k.to += by;
        return true;
    }
    bool take(Sweep& k, const Vec3d& by, int) {
        for (SweepPoint& p : k.points) p.at += by;
        return true;
    }
    /// On a plane n.x = offset with the unit normal n, whatever the length of the scene's; so with mirrors.
    bool take(Plane& k, const Vec3d& by, int) {
        k.offset += k.normal.normalized().dot(by);
        return true;
    }
    bool take(Union& k, const Vec3d& by, int depth) { return move_all(k, by, depth); }
    bool take(Intersection& k, const Vec3d& by, int depth) { return move_all(k, by, depth); }
    bool take(Difference& k, const Vec3d& by, int depth) { return move_all(k, by, depth); }
    bool take(Mirror& k, const Vec3d& by, int depth) {
        k.offset += k.normal.normalized().dot(by);
        return move_all(k, by, depth);
    }
    bool take(Repeat& k, const Vec3d& by, int depth) { return k.turn == 0 && move_all(k, by, depth); }
    /// Its own copy of the named shape is moved: others may use that elsewhere.
    bool take(NamedShape& k, const Vec3d& by, int depth) {
        const auto named = std::ranges::find(shapes_, k.name, &std::pair<std::string, Shape>::first);
        if (named == shapes_.end()) return false;
        Shape copy = named->second;
        move(copy, by, depth + 1);
        k.name += fmt::format("~{}", shapes_.size());  // no name that a scene can give
        shapes_.emplace_back(k.name, std::move(copy));
        return true;
    }
    /// All others stand about their own zero, or bend about it.
    template <class K>
    bool take(K&, const Vec3d&, int) {
        return false;
    }
    bool move_all(ShapeList& list, const Vec3d& by, int depth) {
        for (Shape& shape : list.shapes) move(shape, by, depth + 1);
        return true;
    }

    std::vector<std::pair<std::string, Shape>>& shapes_;
};

}  // namespace

Vec3d origin_for(const Scene& scene, const MeshExtent& mesh_extent) {
    const std::optional<Extent> matter = extent_of_matter(scene, mesh_extent);
    if (!matter) return Vec3d::Zero();
    const Vec3d middle = 0.5 * (matter->lower + matter->upper);
    const double half = 0.5 * (matter->upper - matter->lower).maxCoeff(), away = middle.cwiseAbs().maxCoeff();
    if (!(away > kNearSpacings * scene.solver.spacing) || !(away > kGain * half) || !std::isfinite(away))
        return Vec3d::Zero();
    const double step = std::pow(10, std::ceil(std::log10(kStep * scene.solver.spacing) - 1e-9));
    return Vec3d(std::round(middle.x() / step), std::round(middle.y() / step), std::round(middle.z() / step)) * step;
}

Scene relative_to(Scene scene, const Vec3d& by) {
    if (by.isZero()) return scene;
    Mover mover(scene);
    const auto move = [&](Shape& shape) {
        if (!std::holds_alternative<std::monostate>(shape.kind)) mover.move(shape, -by);
    };
    scene.origin += by;
    for (Boundary& b : scene.world.boundaries) move(b.shape);
    for (HeatSource& h : scene.world.heat_sources) move(h.region);
    for (PeriodicAxis& p : scene.world.periodic) {
        p.from -= by[static_cast<int>(p.axis)];
        p.to -= by[static_cast<int>(p.axis)];
    }
    for (Material& m : scene.materials)
        for (Score& s : m.fracture.scores) move(s.region);
    for (Body& b : scene.bodies) {
        move(b.shape);
        for (PaintedCrack& c : b.cracks) {
            c.image.origin -= by;
            for (CrackPoint& p : c.points) p.at -= by;
        }
    }
    for (Emitter& e : scene.emitters) {
        e.position -= by;
        move(e.shape);
    }
    for (Handle& h : scene.handles) move(h.region);
    for (Blade& b : scene.blades)
        for (EdgePoint& p : b.edge) p.at -= by;
    for (Mould& m : scene.surface.moulds) move(m.shape);
    for (Probe& p : scene.probes) {
        p.position -= by;
        move(p.region);
    }
    scene.look = relative_to(std::move(scene.look), by);
    return scene;
}

Look relative_to(Look look, const Vec3d& by) {
    if (by.isZero()) return look;
    look.camera.position -= by;
    look.camera.look_at -= by;
    for (CameraKey& k : look.camera.path) {
        k.position -= by;
        k.look_at -= by;
    }
    for (Light& l : look.lights) {
        l.position -= by;
        if (l.look_at) *l.look_at -= by;
    }
    for (Appearance& a : look.appearances) {
        // A corner that nobody placed near the scene would be far from it: the picture then counts from the new origin.
        const Vec3d corner = a.image.origin - by;
        if (corner.norm() < a.image.origin.norm()) a.image.origin = corner;
    }
    return look;
}

}  // namespace thixo::scene
