// Moves, offsets, hollows and inverts a shape, and measures its volume.
#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/direct_surface.h"
#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/local_shape.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/point_surfels.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

struct MovedSurface final : DirectSurface {
    MovedSurface(std::shared_ptr<const DirectSurface> i, double f, const Quatd& r, const Vec3d& t)
        : inner(std::move(i)), factor(Real(f)), turn(r.toRotationMatrix().cast<Real>()), shift(t.cast<Real>()) {}
    double area() const override { return square(static_cast<double>(factor)) * inner->area(); }
    void point(double u, double v, double w, Vec3& x, Vec3& normal) const override {
        inner->point(u, v, w, x, normal);
        place(x, normal);
    }
    void project(Vec3& x, Vec3& normal) const override {
        x = turn.transpose() * (x - shift) / factor;
        inner->project(x, normal);
        place(x, normal);
    }
    void place(Vec3& x, Vec3& normal) const {
        x = factor * (turn * x) + shift;
        normal = turn * normal;
    }
    std::shared_ptr<const DirectSurface> inner;
    Real factor;
    Mat3 turn;
    Vec3 shift;
};

struct Transformed final : Shape::Node, PartedNode, SlopedNode {
    Transformed(Shape s, double f, const Quatd& r, const Vec3d& t)
        : shape(std::move(s)),
          factor(Real(f)),
          inverse_factor(Real(1 / f)),
          inverse_rotation(r.conjugate().toRotationMatrix().cast<Real>()),
          translation(t.cast<Real>()),
          rotation(r),
          exact_factor(f),
          exact_translation(t) {}
    Real distance(const Vec3& x) const override {
        return factor * shape.distance(inverse_rotation * (x - translation) * inverse_factor);
    }
    std::optional<Shape> within(const Ball3& ball) const override {
        return with_parts_within(
            *this, {inverse_rotation * (ball.centre - translation) * inverse_factor, ball.radius * inverse_factor});
    }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        Vec3 inner;
        const Real d =
            shape.sloped(inverse_rotation * (x - translation) * inverse_factor, step * inverse_factor, inner);
        slope = inverse_rotation.transpose() * inner;
        return factor * d;
    }
    void distances(const Vec3* x, Real* out, std::size_t n) const override {
        constexpr std::size_t kRow = 32;
        for (std::size_t begin = 0; begin < n; begin += kRow) {
            const std::size_t count = std::min(kRow, n - begin);
            Vec3 inner[kRow];
            for (std::size_t k = 0; k < count; ++k)
                inner[k] = inverse_rotation * (x[begin + k] - translation) * inverse_factor;
            shape.node().distances(inner, out + begin, count);
        }
        for (std::size_t k = 0; k < n; ++k) out[k] *= factor;
    }
    std::optional<Box3> bounds() const override {
        const auto inner = shape.bounds();
        if (!inner) return std::nullopt;
        const Vec3 centre = (inner->lower + inner->upper) / 2, half = (inner->upper - inner->lower) / 2;
        const Mat3 turn = inverse_rotation.transpose();
        const Vec3 c = factor * (turn * centre) + translation, h = factor * (turn.cwiseAbs() * half);
        return Box3{c - h, c + h};
    }
    std::optional<TriangleMesh> exact_mesh(int segments) const override {
        auto mesh = shape.node().exact_mesh(segments);
        if (mesh) transform_mesh(*mesh, exact_factor, rotation, exact_translation);
        return mesh;
    }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        const auto inner = shape.node().faces(by * inverse_factor);
        if (!inner) return nullptr;
        return std::make_shared<FaceTree>(mapped(
            *inner, [&](const Shape& face) { return transformed(face, exact_factor, rotation, exact_translation); }));
    }
    std::optional<Vec3f> colour(const Vec3& x) const override {
        return shape.node().colour(inverse_rotation * (x - translation) * inverse_factor);
    }
    std::shared_ptr<const DirectSurface> direct_surface() const override {
        auto inner = shape.node().direct_surface();
        if (!inner) return nullptr;
        return std::make_shared<MovedSurface>(std::move(inner), exact_factor, rotation, exact_translation);
    }
    std::shared_ptr<const PointSurfels> own_surfels() const override {
        const auto inner = shape.node().own_surfels();
        if (!inner) return nullptr;
        return std::make_shared<PointSurfels>(moved(*inner, exact_factor, rotation, exact_translation));
    }
    SlopedShape shape;
    Real factor, inverse_factor;
    Mat3 inverse_rotation;
    Vec3 translation;
    Quatd rotation;
    double exact_factor;
    Vec3d exact_translation;
};

struct Offset final : Shape::Node, PartedNode, SlopedNode {
    Offset(Shape s, Real d) : shape(std::move(s)), by(d) {
        if (const auto inner = shape.bounds()) {
            const Real shrink = -(inner->upper - inner->lower).minCoeff() / 2;
            box = grown(*inner, std::max(by, shrink));
        }
    }
    Real distance(const Vec3& x) const override {
        const Real d = shape.distance(x) - by;
        if (by >= 0 || !box) return d;
        const Real outside = distance_to(*box, x);  // beyond a corner of the shrunk box d alone may fall below it
        return outside > 0 ? std::max(d, outside) : d;
    }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        const Real d = shape.sloped(x, step, slope) - by;
        return by < 0 && box ? out_of_box(*box, x, d, slope) : d;
    }
    std::optional<Shape> within(const Ball3& ball) const override { return with_parts_within(*this, ball); }
    std::optional<Box3> bounds() const override { return box; }
    std::shared_ptr<const FaceTree> faces(Real more) const override { return shape.node().faces(by + more); }
    std::optional<Vec3f> colour(const Vec3& x) const override { return shape.node().colour(x); }
    SlopedShape shape;
    Real by;
    std::optional<Box3> box;
};

/// The layer between the surface and its offset by `thickness` inwards.
struct Shell final : Shape::Node, PartedNode, SlopedNode {
    Shell(Shape s, Real t) : shape(std::move(s)), thickness(t) {}
    Real distance(const Vec3& x) const override {
        const Real d = shape.distance(x);
        return std::max(d, -d - thickness);
    }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        const Real d = shape.sloped(x, step, slope);
        if (-d - thickness <= d) return d;
        slope = -slope;
        return -d - thickness;
    }
    std::optional<Shape> within(const Ball3& ball) const override { return with_parts_within(*this, ball); }
    std::optional<Box3> bounds() const override { return shape.bounds(); }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        return std::make_shared<FaceTree>(
            FaceTree::of(FaceTree::Op::all, {faces_of(shape, by), complement(faces_of(shape, -thickness - by))}));
    }
    std::optional<Vec3f> colour(const Vec3& x) const override { return shape.node().colour(x); }
    SlopedShape shape;
    Real thickness;
};

struct Inverted final : Shape::Node, PartedNode, SlopedNode {
    explicit Inverted(Shape s) : shape(std::move(s)) {}
    Real distance(const Vec3& x) const override { return -shape.distance(x); }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        const Real d = shape.sloped(x, step, slope);
        slope = -slope;
        return -d;
    }
    std::optional<Shape> within(const Ball3& ball) const override { return with_parts_within(*this, ball); }
    std::optional<Box3> bounds() const override { return std::nullopt; }
    std::optional<TriangleMesh> exact_mesh(int segments) const override {
        auto mesh = shape.node().exact_mesh(segments);
        if (mesh) flip_mesh(*mesh);
        return mesh;
    }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        const auto inner = shape.node().faces(-by);
        return inner ? std::make_shared<FaceTree>(complement(*inner)) : nullptr;
    }
    std::optional<Vec3f> colour(const Vec3& x) const override { return shape.node().colour(x); }
    SlopedShape shape;
};

}  // namespace

Shape transformed(Shape shape, double factor, const Quatd& rotation, const Vec3d& translation) {
    positive_size(factor, "scale");
    finite_vector(rotation.coeffs(), "rotation");
    finite_vector(translation, "translation");
    if (!(rotation.norm() > 0)) throw InputError("rotation is the zero quaternion; give a unit quaternion");
    return Shape(std::make_shared<Transformed>(std::move(shape), factor, rotation.normalized(), translation));
}
Shape scaled(Shape shape, double factor) {
    return transformed(std::move(shape), factor, Quatd::Identity(), Vec3d::Zero());
}
Shape rotated(Shape shape, const Quatd& rotation) { return transformed(std::move(shape), 1, rotation, Vec3d::Zero()); }
Shape translated(Shape shape, const Vec3d& by) { return transformed(std::move(shape), 1, Quatd::Identity(), by); }

Shape offset(Shape shape, double by) {
    finite_number(by, "offset");
    return Shape(std::make_shared<Offset>(std::move(shape), Real(by)));
}
Shape shell(Shape shape, double thickness) {
    positive_size(thickness, "shell thickness");
    return Shape(std::make_shared<Shell>(std::move(shape), Real(thickness)));
}
Shape inverted(Shape shape) { return Shape(std::make_shared<Inverted>(std::move(shape))); }

namespace {

/// Cells of a box that grow from its lower corner.
struct Cells {
    Vec3d lower, edges;  // [m]
    Eigen::Array3d count;
};

Box3 bounds_of(const Shape& shape, double cell) {
    positive_size(cell, "volume cell");
    const auto bounds = shape.bounds();
    if (!bounds) throw InputError("the volume of an unbounded shape is not finite; intersect it with a box");
    return *bounds;
}

/// Sums term(centre, part) over cells, with the part that each is filled to. See `volume`.
template <class Sum, class Term>
Sum sum_over_cells(const Shape& shape, const Cells& cells, Term&& term) {
    if (cells.count.prod() > double(1ull << 36))
        throw InputError("volume cell {} m is too fine for this shape; use a larger one", cells.edges.minCoeff());
    const std::size_t nx = std::size_t(cells.count.x()), ny = std::size_t(cells.count.y()),
                      nz = std::size_t(cells.count.z());
    const double width = cells.edges.minCoeff();
    const auto column = [&](std::size_t k) {
        const auto centre = [&](std::size_t x) {
            return Vec3d(cells.lower +
                         cells.edges.cwiseProduct(Vec3d(double(x) + 0.5, double(k % ny) + 0.5, double(k / ny) + 0.5)));
        };
        Sum sum{};
        for (std::size_t x = 0; x < nx;) {
            const std::size_t x0 = x;
            const double distance = double(shape.distance(centre(x0).template cast<Real>())) / width;
            if (const double part = clamp01(0.5 - distance); part > 0) sum += term(centre(x0), part);
            // The distance changes by at most twice the way. So far everything is inside, or everything is outside.
            const double clear = (std::abs(distance) - 0.5) / 2 * width / cells.edges.x();
            for (++x; x < nx && double(x) < double(x0) + clear; ++x)
                if (distance < 0) sum += term(centre(x), 1.0);
        }
        return sum;
    };
    return parallel_sum(ny * nz, column, Sum{});
}

}  // namespace

double volume(const Shape& shape, double cell) {
    const Box3 box = grown(bounds_of(shape, cell), Real(cell));
    const Cells cells{box.lower.cast<double>(), Vec3d::Constant(cell),
                      ((box.upper - box.lower).cast<double>().array() / cell).ceil()};
    return cube(cell) * sum_over_cells<double>(shape, cells, [](const Vec3d&, double part) { return part; });
}

ShapeMoments moments(const Shape& shape, double cell) {
    const Box3 box = bounds_of(shape, cell);
    const Vec3d size = (box.upper - box.lower).cast<double>();
    const Eigen::Array3d count = (size.array() / cell).ceil().max(1);
    const Cells cells{box.lower.cast<double>(), size.cwiseQuotient(count.matrix()), count};
    ShapeMoments sum = sum_over_cells<ShapeMoments>(shape, cells, [](const Vec3d& x, double part) {
        return ShapeMoments{part, part * x, part * x * x.transpose()};
    });
    // A cell has a second moment about its own centre.
    sum.second.diagonal() += sum.volume / 12 * cells.edges.cwiseAbs2();
    const double unit = cells.edges.prod();
    return {unit * sum.volume, unit * sum.first, unit * sum.second};
}

Quatd rotation_from_degrees(const Vec3d& degrees) {
    const Vec3d a = degrees * (kPi / 180);
    return Quatd(Eigen::AngleAxisd(a.z(), Vec3d::UnitZ()) * Eigen::AngleAxisd(a.y(), Vec3d::UnitY()) *
                 Eigen::AngleAxisd(a.x(), Vec3d::UnitX()));
}

}  // namespace thixo
