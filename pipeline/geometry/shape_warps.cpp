// Twisted and bent shapes.
#include <algorithm>
#include <cmath>

#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

/// A warped shape, by a map from the world to the straight shape. The map gives
///     straight(x)   the place in the straight shape
///     stretch       the greatest stretch of that map
///     outside(x)    the distance to a set around the warped shape, a union of convex sets [m]
///     margin        how far from that set the stretch holds [m]
/// The distance d below changes no faster than x moves and is a lower bound:
///     inner = min(shape(straight(x)) / stretch, margin - outside(x))  [m]
///     d = max(outside(x), inner) where outside(x) > 0, else inner  [m]
template <class Map>
struct Warped final : Shape::Node {
    Warped(Shape s, const Map& m, bool whole_) : shape(std::move(s)), map(m), whole(whole_) {}
    Real distance(const Vec3& x) const override {
        const Real d = shape.distance(map.straight(x)) / map.stretch;
        if (!whole) return d;
        const Real outside = map.outside(x), inner = std::min(d, map.margin - outside);
        return outside > 0 ? std::max(outside, inner) : inner;
    }
    std::optional<Box3> bounds() const override { return whole ? std::optional(map.box) : std::nullopt; }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        const auto inner = shape.node().faces(by * map.stretch);
        if (!inner) return nullptr;
        return std::make_shared<FaceTree>(
            mapped(*inner, [&](const Shape& face) { return Shape(std::make_shared<Warped>(face, map, false)); }));
    }
    std::optional<Vec3f> colour(const Vec3& x) const override { return shape.node().colour(map.straight(x)); }
    Shape shape;
    Map map;
    bool whole;  // false: a face, which extends beyond the shape
};

struct Twist {
    Twist(const Box3& straight_box, Real rate_)
        : rate(rate_), bottom(straight_box.lower.z()), top(straight_box.upper.z()) {
        const Vec3 far = straight_box.lower.cwiseAbs().cwiseMax(straight_box.upper.cwiseAbs());
        radius = far.head<2>().norm();
        margin = Real(0.5) * std::max(radius, top - bottom);
        // The greatest stretch of a shear by s is
        //     (s + sqrt(s^2 + 4))/2
        const Real shear = std::abs(rate) * (radius + margin);
        stretch = (shear + std::sqrt(shear * shear + 4)) / 2;
        box = Box3{Vec3(-radius, -radius, bottom), Vec3(radius, radius, top)};
    }
    Vec3 straight(const Vec3& x) const {
        const Real angle = -rate * x.z(), c = std::cos(angle), s = std::sin(angle);
        return {c * x.x() - s * x.y(), s * x.x() + c * x.y(), x.z()};
    }
    Real outside(const Vec3& x) const {
        const Real r = std::max(x.head<2>().norm() - radius, Real(0));
        const Real z = std::max({bottom - x.z(), x.z() - top, Real(0)});
        return std::sqrt(r * r + z * z);
    }
    Real rate, bottom, top, radius, margin, stretch;
    Box3 box;
};

/// The bend maps a material point (x, z) to
///     centre + (R - x) (-cos phi, sin phi),  phi = (z - bottom)/R,  centre = (R, bottom)
struct Bend {
    Bend(const Box3& straight_box, Real angle_) : angle(angle_), bottom(straight_box.lower.z()) {
        lower_y = straight_box.lower.y();
        upper_y = straight_box.upper.y();
        R = (straight_box.upper.z() - bottom) / angle;
        inner = R - straight_box.upper.x();
        outer = R - straight_box.lower.x();
        margin = std::min(inner / 2, outer);
        stretch = std::max(Real(1), R / (inner - margin));
        const Real far = std::max(outer, Real(0));
        box = Box3{Vec3(R - far, lower_y, bottom), Vec3(R + far, upper_y, bottom + far)};
        if (angle <= Real(kPi / 2))
            box.upper.x() = R - inner * std::cos(angle), box.upper.z() = bottom + far * std::sin(angle);
        if (angle > Real(kPi / 2)) box.upper.x() = R - far * std::cos(angle);
    }
    /// The angle from the start of the arc. It jumps half a turn away from the middle of the arc.
    Real turn(Real dx, Real dz) const {
        const Real c = std::cos(angle / 2), s = std::sin(angle / 2);
        return std::atan2(c * dz - s * dx, c * dx + s * dz) + angle / 2;
    }
    Vec3 straight(const Vec3& x) const {
        const Real dx = R - x.x(), dz = x.z() - bottom;
        return {R - std::sqrt(dx * dx + dz * dz), x.y(), bottom + R * turn(dx, dz)};
    }
    /// Distance to the sector of the arc, or to the hole inside it.
    Real outside(const Vec3& x) const {
        const Real dx = R - x.x(), dz = x.z() - bottom, r = std::sqrt(dx * dx + dz * dz), phi = turn(dx, dz);
        Real plane = std::max(r - outer, Real(0));
        const Real beyond = std::max(-phi, phi - angle);
        if (beyond > 0) {
            const Real along = r * std::cos(beyond), across = r * std::sin(beyond);
            plane = beyond > Real(kPi / 2) ? r : along > outer ? std::hypot(along - outer, across) : across;
        }
        const Real y = std::max({lower_y - x.y(), x.y() - upper_y, Real(0)});
        return std::max(std::sqrt(plane * plane + y * y), inner - r);
    }
    Real angle, bottom, lower_y, upper_y, R, inner, outer, margin, stretch;
    Box3 box;
};

Box3 bounds_of(const Shape& shape, const char* what) {
    const auto box = shape.bounds();
    if (!box) throw InputError("an unbounded shape cannot be {}; intersect it with a box", what);
    return *box;
}

}  // namespace

Shape twisted(Shape shape, double rate) {
    finite_number(rate, "twist rate");
    const Box3 box = bounds_of(shape, "twisted");
    return Shape(std::make_shared<Warped<Twist>>(std::move(shape), Twist(box, Real(rate * kPi / 180)), true));
}

Shape bent(Shape shape, double angle) {
    finite_number(angle, "bend angle");
    if (std::abs(angle) > 180) throw InputError("bend angle is {}; it must be from -180 to 180 degrees", angle);
    if (angle < 0) {
        const Quatd half_turn(Eigen::AngleAxisd(kPi, Vec3d::UnitZ()));
        return rotated(bent(rotated(std::move(shape), half_turn), -angle), half_turn);
    }
    if (angle == 0) return shape;
    const Box3 box = bounds_of(shape, "bent");
    const Bend bend(box, Real(angle * kPi / 180));
    if (!(bend.inner > Real(0.02) * bend.R))
        throw InputError("bend angle is {}: the shape's inner side, at x = {}, would fold about x = {}; bend it less",
                         angle, box.upper.x(), bend.R);
    return Shape(std::make_shared<Warped<Bend>>(std::move(shape), bend, true));
}

}  // namespace thixo
