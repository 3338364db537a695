// Images and copies of a shape.
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/local_shape.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

/// The mirror image without the shape itself.
struct Reflected final : Shape::Node, PartedNode, SlopedNode {
    Reflected(Shape s, const Vec3& n, Real o) : shape(std::move(s)), normal(n), offset(o) {}
    Vec3 image(const Vec3& x) const { return x - 2 * (normal.dot(x) - offset) * normal; }
    Real distance(const Vec3& x) const override { return shape.distance(image(x)); }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        const Real d = shape.sloped(image(x), step, slope);
        slope -= 2 * normal.dot(slope) * normal;
        return d;
    }
    std::optional<Shape> within(const Ball3& ball) const override {
        return with_parts_within(*this, {image(ball.centre), ball.radius});
    }
    std::optional<Box3> bounds() const override {
        const auto inner = shape.bounds();
        if (!inner) return std::nullopt;
        const Mat3 turn = Mat3::Identity() - 2 * normal * normal.transpose();
        const Vec3 c = image((inner->lower + inner->upper) / 2),
                   h = turn.cwiseAbs() * (inner->upper - inner->lower) / 2;
        return Box3{c - h, c + h};
    }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        const auto inner = shape.node().faces(by);
        if (!inner) return nullptr;
        return std::make_shared<FaceTree>(mapped(
            *inner, [&](const Shape& face) { return Shape(std::make_shared<Reflected>(face, normal, offset)); }));
    }
    std::optional<Vec3f> colour(const Vec3& x) const override { return shape.node().colour(image(x)); }
    SlopedShape shape;
    Vec3 normal;
    Real offset;
};

/// The union of many similar shapes. Shapes whose boxes are farther than another's surface are not evaluated.
struct Copies final : Shape::Node, PartedNode, SlopedNode {
    explicit Copies(const std::vector<Shape>& list) : shapes(list.begin(), list.end()) {
        for (const Shape& shape : shapes) boxes.push_back(*shape.bounds());
        box = boxes[0];
        for (const Box3& b : boxes) box = joined(box, b);
    }
    /// The shape whose box is nearest is evaluated first.
    std::size_t nearest(const Vec3& x, Real& d) const {
        std::size_t found = 0;
        Real least = std::numeric_limits<Real>::max();
        for (std::size_t k = 0; k < shapes.size(); ++k)
            if (const Real away = distance_to(boxes[k], x); away < least) {
                least = away;
                found = k;
            }
        const std::size_t first = found;
        d = shapes[first].distance(x);
        for (std::size_t k = 0; k < shapes.size(); ++k) {
            if (k == first) continue;
            if (const Real away = distance_to(boxes[k], x); away > 0 && away >= d) continue;
            if (const Real other = shapes[k].distance(x); other < d || (other == d && k < found)) {
                d = other;
                found = k;
            }
        }
        return found;
    }
    Real distance(const Vec3& x) const override {
        Real d;
        nearest(x, d);
        return d;
    }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        Real d;
        return shapes[nearest(x, d)].sloped(x, step, slope);
    }
    std::optional<Shape> within(const Ball3& ball) const override {
        Real least;
        nearest(ball.centre, least);
        const Real most = least + 2 * ball.radius;
        std::vector<Shape> kept;
        for (std::size_t k = 0; k < shapes.size(); ++k)
            if (distance_to(boxes[k], ball.centre) <= std::max(most, Real(0)) &&
                shapes[k].distance(ball.centre) <= most)
                kept.push_back(parts_within(shapes[k], ball).value_or(shapes[k]));
        if (kept.size() == 1) return kept[0];
        return Shape(std::make_shared<Copies>(std::move(kept)));
    }
    std::optional<Box3> bounds() const override { return box; }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        FaceTree tree{FaceTree::Op::any};
        for (const Shape& shape : shapes) tree.parts.push_back(faces_of(shape, by));
        return std::make_shared<FaceTree>(std::move(tree));
    }
    std::optional<Vec3f> colour(const Vec3& x) const override {
        Real d;
        return shapes[nearest(x, d)].node().colour(x);
    }
    std::vector<SlopedShape> shapes;
    std::vector<Box3> boxes;
    Box3 box;
};

}  // namespace

Shape mirrored(Shape shape, const Vec3d& normal, double offset, double smooth) {
    finite_vector(normal, "mirror normal");
    finite_number(offset, "mirror offset");
    const double length = normal.norm();
    if (!(length > 0)) throw InputError("mirror normal is zero; give a direction across the mirror");
    Shape image(std::make_shared<Reflected>(shape, (normal / length).cast<Real>(), Real(offset)));
    return union_of({std::move(shape), std::move(image)}, smooth);
}

Shape repeated(Shape shape, int count, const Vec3d& step, double turn, double smooth) {
    finite_vector(step, "repeat step");
    finite_number(turn, "repeat turn");
    if (count < 1 || count > 10000) throw InputError("repeat count is {}; use 1 to 10000", count);
    std::vector<Shape> copies{shape};
    for (int k = 1; k < count; ++k)
        copies.push_back(
            transformed(shape, 1, Quatd(Eigen::AngleAxisd(k * turn * kPi / 180, Vec3d::UnitZ())), k * step));
    if (smooth > 0 || !shape.bounds() || count == 1) return union_of(std::move(copies), smooth);
    return Shape(std::make_shared<Copies>(std::move(copies)));
}

}  // namespace thixo
