// Union, intersection and difference of shapes, sharp or blended.
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/local_shape.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

/// The smooth minimum: never above min(a, b), with a convex combination of the two gradients as its gradient.
Real smooth_min(Real a, Real b, Real radius) {
    const Real overlap = radius - std::abs(a - b);
    return std::min(a, b) - (overlap > 0 ? overlap * overlap / (4 * radius) : Real(0));
}

/// The same. slope_a is the gradient of a and becomes that of the result.
Real smooth_min(Real a, Real b, Real radius, Vec3& slope_a, const Vec3& slope_b) {
    const Real overlap = radius - std::abs(a - b), other = overlap > 0 ? overlap / (2 * radius) : Real(0);
    const Real part_b = a <= b ? other : 1 - other;
    slope_a += part_b * (slope_b - slope_a);
    return smooth_min(a, b, radius);
}

/// The colour of the shape whose surface is nearest.
std::optional<Vec3f> colour_of_nearest(const std::vector<SlopedShape>& shapes, const Vec3& x) {
    const Shape* nearest = nullptr;
    Real best = std::numeric_limits<Real>::max();
    for (const Shape& shape : shapes)
        if (const Real d = std::abs(shape.distance(x)); d < best) {
            best = d;
            nearest = &shape;
        }
    return nearest ? nearest->node().colour(x) : std::nullopt;
}

/// The boxes of shapes. No shape is nearer than its box, whose distance is cheap.
class Boxes {
  public:
    explicit Boxes(const std::vector<SlopedShape>& shapes) {
        for (const Shape& shape : shapes) boxes_.push_back(shape.bounds());
    }
    bool farther(std::size_t k, const Vec3& x, Real than) const {
        if (!boxes_[k]) return false;
        const Vec3 away = (boxes_[k]->lower - x).cwiseMax(x - boxes_[k]->upper).cwiseMax(Real(0));
        return away.squaredNorm() > square(std::max(than, Real(0)));
    }

  private:
    std::vector<std::optional<Box3>> boxes_;
};

/// A value this far above the least of n folded values does not change the result. A fold lowers a value by smooth/4 at
/// most, and it takes in values up to `smooth` above.
Real traceless(Real smooth, std::size_t n) { return smooth * (2 + Real(n) / 4); }

/// The shapes whose value may come within `margin` of the least one in the ball, each with the parts that matter there.
/// `value` maps a distance to the value. The first shape always belongs to them with `keep_first`. Empty where no shape
/// and no part can be left out.
template <class F>
std::vector<Shape> least_in(const std::vector<SlopedShape>& shapes, const Ball3& ball, Real margin, bool keep_first,
                            F&& value) {
    std::vector<Real> at_centre;
    for (std::size_t k = 0; k < shapes.size(); ++k) at_centre.push_back(value(k, shapes[k].distance(ball.centre)));
    const Real most = *std::ranges::min_element(at_centre) + 2 * ball.radius + margin;
    std::vector<Shape> kept;
    bool same = true;
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        if (at_centre[k] > most && !(keep_first && k == 0)) continue;
        const auto part = parts_within(shapes[k], ball);
        kept.push_back(part.value_or(shapes[k]));
        same &= !part;
    }
    if (same && kept.size() == shapes.size()) kept.clear();
    return kept;
}

struct Union final : Shape::Node, PartedNode, SlopedNode {
    Union(const std::vector<Shape>& list, Real radius)
        : shapes(list.begin(), list.end()), boxes(shapes), smooth(radius) {
        box = shapes[0].bounds();
        for (const Shape& shape : shapes) {
            const auto other = shape.bounds();
            box = box && other ? std::optional(joined(*box, *other)) : std::nullopt;
        }
        // Each fold lowers the value by smooth/4 at most.
        if (box) box = grown(*box, smooth / 4 * Real(shapes.size() - 1));
    }
    Real distance(const Vec3& x) const override {
        Real d = shapes[0].distance(x);
        for (std::size_t k = 1; k < shapes.size(); ++k) {
            if (boxes.farther(k, x, d + smooth)) continue;
            const Real other = shapes[k].distance(x);
            d = smooth > 0 ? smooth_min(d, other, smooth) : std::min(d, other);
        }
        return d;
    }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        Real d = shapes[0].sloped(x, step, slope);
        for (std::size_t k = 1; k < shapes.size(); ++k) {
            if (boxes.farther(k, x, d + smooth)) continue;
            Vec3 other_slope;
            const Real other = shapes[k].sloped(x, step, other_slope);
            if (smooth > 0) {
                d = smooth_min(d, other, smooth, slope, other_slope);
            } else if (other < d) {
                d = other;
                slope = other_slope;
            }
        }
        return d;
    }
    std::optional<Shape> within(const Ball3& ball) const override {
        std::vector<Shape> kept = least_in(shapes, ball, traceless(smooth, shapes.size()), false,
                                           [](std::size_t, Real distance) { return distance; });
        if (kept.empty()) return std::nullopt;
        if (kept.size() == 1) return kept[0];
        return Shape(std::make_shared<Union>(std::move(kept), smooth));
    }
    std::optional<Box3> bounds() const override { return box; }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        if (smooth > 0) return nullptr;
        FaceTree tree{FaceTree::Op::any};
        for (const Shape& shape : shapes) tree.parts.push_back(faces_of(shape, by));
        return std::make_shared<FaceTree>(std::move(tree));
    }
    std::optional<Vec3f> colour(const Vec3& x) const override { return colour_of_nearest(shapes, x); }
    std::vector<SlopedShape> shapes;
    Boxes boxes;
    Real smooth;
    std::optional<Box3> box;
};

/// The intersection of the first shape with the others, or, with `less`, with their complements.
struct Intersection final : Shape::Node, PartedNode, SlopedNode {
    Intersection(const std::vector<Shape>& list, Real radius, bool less_)
        : shapes(list.begin(), list.end()), boxes(shapes), smooth(radius), less(less_) {
        box = shapes[0].bounds();
        for (std::size_t k = 1; k < shapes.size() && !less; ++k) {
            const auto other = shapes[k].bounds();
            box = box && other ? std::optional(common(*box, *other)) : (box ? box : other);
        }
    }
    Real distance(const Vec3& x) const override {
        Real d = shapes[0].distance(x);
        for (std::size_t k = 1; k < shapes.size(); ++k) {
            if (less && boxes.farther(k, x, smooth - d)) continue;
            const Real other = less ? -shapes[k].distance(x) : shapes[k].distance(x);
            d = smooth > 0 ? -smooth_min(-d, -other, smooth) : std::max(d, other);
        }
        // Beside a thin wedge the maximum can be far too low. The distance to the box keeps it a usable bound, so that
        // shapes blend only near it.
        return box ? std::max(d, outside(x)) : d;
    }
    /// Evaluates the union of the complements.
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        Real d = -shapes[0].sloped(x, step, slope);
        slope = -slope;
        for (std::size_t k = 1; k < shapes.size(); ++k) {
            if (less && boxes.farther(k, x, smooth + d)) continue;
            Vec3 other_slope;
            Real other = shapes[k].sloped(x, step, other_slope);
            if (!less) {
                other = -other;
                other_slope = -other_slope;
            }
            if (smooth > 0) {
                d = smooth_min(d, other, smooth, slope, other_slope);
            } else if (other < d) {
                d = other;
                slope = other_slope;
            }
        }
        slope = -slope;
        return box ? out_of_box(*box, x, -d, slope) : -d;
    }
    /// The first shape stays, because its sign differs in a difference; so does the box.
    std::optional<Shape> within(const Ball3& ball) const override {
        std::vector<Shape> kept =
            least_in(shapes, ball, traceless(smooth, shapes.size()), true,
                     [&](std::size_t k, Real distance) { return less && k > 0 ? distance : -distance; });
        if (kept.empty()) return std::nullopt;
        const bool in_box = !box || ((ball.centre - box->lower).minCoeff() > ball.radius &&
                                     (box->upper - ball.centre).minCoeff() > ball.radius);
        if (kept.size() == 1 && in_box) return kept[0];
        auto part = std::make_shared<Intersection>(std::move(kept), smooth, less);
        part->box = box;
        return Shape(std::move(part));
    }
    std::optional<Box3> bounds() const override { return box; }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        if (smooth > 0) return nullptr;
        FaceTree tree{less ? FaceTree::Op::except : FaceTree::Op::all};
        for (const Shape& shape : shapes) tree.parts.push_back(faces_of(shape, less && !tree.parts.empty() ? -by : by));
        return std::make_shared<FaceTree>(std::move(tree));
    }

    /// The distance to the box where x is outside; no bound inside.
    Real outside(const Vec3& x) const {
        const Real d = distance_to(*box, x);
        return d > 0 ? d : std::numeric_limits<Real>::lowest();
    }
    std::optional<Vec3f> colour(const Vec3& x) const override { return colour_of_nearest(shapes, x); }
    std::vector<SlopedShape> shapes;
    Boxes boxes;
    Real smooth;
    bool less;
    std::optional<Box3> box;
};

void check_list(const std::vector<Shape>& shapes, double smooth, const char* what) {
    if (shapes.empty()) throw InputError("{} has no shapes; give it at least one", what);
    size_not_negative(smooth, "smooth");
}

}  // namespace

Shape union_of(std::vector<Shape> shapes, double smooth) {
    check_list(shapes, smooth, "union");
    if (shapes.size() == 1) return shapes[0];
    return Shape(std::make_shared<Union>(std::move(shapes), Real(smooth)));
}

Shape intersection_of(std::vector<Shape> shapes, double smooth) {
    check_list(shapes, smooth, "intersection");
    if (shapes.size() == 1) return shapes[0];
    return Shape(std::make_shared<Intersection>(std::move(shapes), Real(smooth), false));
}

Shape difference_of(std::vector<Shape> shapes, double smooth) {
    check_list(shapes, smooth, "difference");
    if (shapes.size() == 1) return shapes[0];
    return Shape(std::make_shared<Intersection>(std::move(shapes), Real(smooth), true));
}

}  // namespace thixo
