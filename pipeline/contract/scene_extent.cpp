#include "pipeline/contract/scene_extent.h"

#include <algorithm>
#include <cmath>

namespace thixo::scene {
namespace {

/// A box that grows. It is unknown where a part of it is.
struct Growing {
    Vec3d lower = Vec3d::Constant(1e300), upper = Vec3d::Constant(-1e300);
    bool unknown = false, endless = false;

    bool empty() const { return lower.x() > upper.x(); }
    bool sized() const { return !unknown && !endless && !empty(); }
    void add(const Vec3d& x) {
        lower = lower.cwiseMin(x);
        upper = upper.cwiseMax(x);
    }
    void add(const Growing& b) {
        unknown = unknown || b.unknown;
        endless = endless || b.endless;
        if (b.empty()) return;
        add(b.lower);
        add(b.upper);
    }
    void grow(double by) {
        lower -= Vec3d::Constant(by);
        upper += Vec3d::Constant(by);
    }
    double reach() const { return empty() ? 0 : lower.cwiseAbs().cwiseMax(upper.cwiseAbs()).norm(); }
    /// The box about f(x) of its corners.
    template <class F>
    Growing mapped(F&& f) const {
        Growing b;
        b.unknown = unknown;
        b.endless = endless;
        for (int c = 0; c < 8 && !empty(); ++c)
            b.add(
                f(Vec3d(c & 1 ? upper.x() : lower.x(), c & 2 ? upper.y() : lower.y(), c & 4 ? upper.z() : lower.z())));
        return b;
    }
};

Growing box(const Vec3d& half) {
    Growing b;
    b.add(-half);
    b.add(half);
    return b;
}

class Extents {
  public:
    explicit Extents(const Scene& scene, MeshExtent mesh_extent = nullptr)
        : scene_(scene), mesh_extent_(std::move(mesh_extent)) {}

    Growing of(const Shape& s) {
        Growing b = std::visit([&](const auto& kind) { return of_kind(kind); }, s.kind);
        const Mat3d turn = rotation(s.rotate);
        b = b.mapped([&](const Vec3d& x) { return Vec3d(turn * (s.scale * x) + s.translate); });
        b.grow(std::max(0.0, s.offset));
        return b;
    }

  private:
    Growing of_kind(const std::monostate&) { return {}; }
    Growing of_kind(const Sphere& s) { return box(Vec3d::Constant(s.radius)); }
    Growing of_kind(const Ellipsoid& s) { return box(s.radii); }
    Growing of_kind(const BoxShape& s) { return box(0.5 * s.size); }
    Growing of_kind(const Cylinder& s) { return box({s.radius, s.radius, 0.5 * s.height}); }
    Growing of_kind(const RoundedCone& s) {
        const double r = std::max(s.radius1, s.radius2);
        Growing b = box({r, r, s.radius1});
        b.add(Vec3d(0, 0, s.height + s.radius2));
        return b;
    }
    Growing of_kind(const Capsule& s) {
        Growing b;
        b.add(s.from);
        b.add(s.to);
        b.grow(s.radius);
        return b;
    }
    Growing of_kind(const Torus& s) { return box({s.radius + s.tube, s.radius + s.tube, s.tube}); }
    Growing of_kind(const Plane&) {
        Growing b;
        b.endless = true;
        return b;
    }
    Growing of_kind(const Revolve& s) {
        Growing b;
        for (const Vec2d& p : s.profile) {
            b.add(Vec3d(p.x(), p.x(), p.y()));
            b.add(Vec3d(-p.x(), -p.x(), p.y()));
        }
        return b;
    }
    Growing of_kind(const Sweep& s) {
        Growing b;
        for (const SweepPoint& p : s.points) {
            b.add(p.at + Vec3d::Constant(p.radius));
            b.add(p.at - Vec3d::Constant(p.radius));
        }
        return b;
    }
    /// Most models are about as wide as high.
    Growing of_kind(const MeshFile& s) {
        if (s.place == Place::file && mesh_extent_) return in_file(s, mesh_extent_(s));
        Growing b = box(Vec3d::Constant(0.5 * s.height));
        if (s.place == Place::base)
            b = b.mapped([&](const Vec3d& x) { return Vec3d(x + Vec3d(0, 0, 0.5 * s.height)); });
        b.unknown = s.height == 0 || s.place == Place::file;
        return b.mapped([&](const Vec3d& x) { return Vec3d(x + s.shift); });
    }
    static Growing in_file(const MeshFile& s, const Extent& extent) {
        const double height = extent.upper.z() - extent.lower.z();
        const double scale = s.scale > 0 ? s.scale : height > 0 ? s.height / height : 1;
        Growing b;
        b.add(scale * extent.lower + s.shift);
        b.add(scale * extent.upper + s.shift);
        return b;
    }
    Growing all(const ShapeList& list) {
        Growing b;
        for (const Shape& s : list.shapes) b.add(of(s));
        return b;
    }
    Growing of_kind(const Union& s) { return all(s); }
    Growing of_kind(const Difference& s) { return s.shapes.empty() ? Growing() : of(s.shapes[0]); }
    /// No larger than the smallest of its parts.
    Growing of_kind(const Intersection& s) {
        Growing smallest, together;
        for (const Shape& part : s.shapes) {
            const Growing b = of(part);
            together.add(b);
            if (b.sized() && (!smallest.sized() || b.reach() < smallest.reach())) smallest = b;
        }
        return smallest.sized() ? smallest : together;
    }
    Growing of_kind(const Mirror& s) {
        const Vec3d n = s.normal.normalized();
        Growing b = all(s);
        b.add(b.mapped([&](const Vec3d& x) { return Vec3d(x - 2 * (n.dot(x) - s.offset) * n); }));
        return b;
    }
    Growing of_kind(const Repeat& s) {
        const Growing one = all(s);
        Growing b = one;
        for (int k = 1; k < s.count; ++k) {
            const Mat3d turn = rotation({0, 0, k * s.turn});
            b.add(one.mapped([&](const Vec3d& x) { return Vec3d(turn * x + k * s.step); }));
        }
        return b;
    }
    Growing ball(const ShapeList& s) {
        const Growing b = all(s);
        Growing round = box(Vec3d::Constant(b.reach()));
        round.unknown = b.unknown;
        round.endless = b.endless;
        return round;
    }
    Growing of_kind(const Twist& s) { return ball(s); }
    Growing of_kind(const Bend& s) { return ball(s); }
    Growing of_kind(const Noise& s) { return all(s); }
    Growing of_kind(const NamedShape& s) {
        for (const auto& [name, shape] : scene_.shapes)
            if (name == s.name) return of(shape);
        return {};
    }

    const Scene& scene_;
    MeshExtent mesh_extent_;
};

Growing matter_of(const Scene& scene, Extents& extents) {
    Growing all;
    for (const Body& b : scene.bodies) all.add(extents.of(b.shape));
    for (const Emitter& e : scene.emitters) {
        Growing opening = extents.of(e.shape);
        if (opening.empty()) opening.add(e.position);
        all.add(opening);
    }
    return all;
}

constexpr double kNearSizes = 4;  // sizes of the matter

}  // namespace

Mat3d rotation(const Vec3d& degrees) {
    const auto about = [&](int axis) {
        return Eigen::AngleAxisd(degrees[axis] * kPi / 180, Vec3d::Unit(axis)).toRotationMatrix();
    };
    return about(2) * about(1) * about(0);
}

std::optional<PlacedPlane> placed_plane(const Shape& shape) {
    const auto* plane = std::get_if<Plane>(&shape.kind);
    if (!plane) return std::nullopt;
    const Vec3d n = rotation(shape.rotate) * plane->normal.normalized();
    return PlacedPlane{shape.translate + (shape.scale * plane->offset + shape.offset) * n, n};
}

std::optional<Extent> extent_of(const Scene& scene) {
    Extents extents(scene);
    Growing all = matter_of(scene, extents);
    if (!all.sized()) return std::nullopt;
    const Vec3d middle = 0.5 * (all.lower + all.upper);
    const double near = kNearSizes * std::max((all.upper - all.lower).norm(), 10 * scene.solver.spacing);
    for (const Boundary& b : scene.world.boundaries) {
        if (!b.visible) continue;
        if (const Growing part = extents.of(b.shape); part.sized() && (part.upper - part.lower).norm() <= near)
            all.add(part);
        if (const auto plane = placed_plane(b.shape)) {
            const double height = plane->normal.dot(middle - plane->on);
            if (std::abs(height) <= near) all.add(Vec3d(middle - height * plane->normal));
        }
    }
    all.grow(scene.solver.spacing);
    return Extent{all.lower, all.upper};
}

std::optional<Extent> extent_of_matter(const Scene& scene, const MeshExtent& mesh_extent) {
    Extents extents(scene, mesh_extent);
    const Growing all = matter_of(scene, extents);
    if (all.empty()) return std::nullopt;
    return Extent{all.lower, all.upper};
}

}  // namespace thixo::scene
