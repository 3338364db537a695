// Primitives with round and flat faces.
#include <algorithm>
#include <cmath>

#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/primitive_mesh.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

Real length_of(Real a, Real b) { return std::sqrt(a * a + b * b); }

struct Sphere final : Shape::Node, SlopedNode {
    explicit Sphere(Real r) : radius(r) {}
    Real distance(const Vec3& x) const override { return x.norm() - radius; }
    Real sloped(const Vec3& x, Real, Vec3& slope) const override {
        const Real r = x.norm();
        slope = r > 0 ? Vec3(x / r) : Vec3::Zero();
        return r - radius;
    }
    std::optional<Box3> bounds() const override { return Box3{Vec3::Constant(-radius), Vec3::Constant(radius)}; }
    std::optional<TriangleMesh> exact_mesh(int segments) const override { return sphere_mesh(radius, segments); }
    Real radius;
};

struct Box final : Shape::Node {
    Box(const Vec3& half_size, Real rounding_) : core(half_size.array() - rounding_), rounding(rounding_) {}
    Real distance(const Vec3& x) const override {
        const Vec3 q = x.cwiseAbs() - core;
        return q.cwiseMax(Real(0)).norm() + std::min(q.maxCoeff(), Real(0)) - rounding;
    }
    std::optional<Box3> bounds() const override {
        const Vec3 half = core.array() + rounding;
        return Box3{-half, half};
    }
    std::optional<TriangleMesh> exact_mesh(int segments) const override { return box_mesh(core, rounding, segments); }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        if (rounding + by > 0) return nullptr;
        FaceTree tree{FaceTree::Op::all};
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {1.0, -1.0})
                tree.parts.push_back(
                    FaceTree::leaf(plane(side * Vec3d::Unit(axis), static_cast<double>(core[axis] + rounding + by))));
        return std::make_shared<FaceTree>(std::move(tree));
    }
    Vec3 core;  // half edges of the inner box, whose offset by the rounding is this box
    Real rounding;
};

/// The side of a cylinder, extended without end along the z axis.
struct Tube final : Shape::Node {
    explicit Tube(Real r) : radius(r) {}
    Real distance(const Vec3& x) const override { return length_of(x.x(), x.y()) - radius; }
    std::optional<Box3> bounds() const override { return std::nullopt; }
    Real radius;
};

struct Cylinder final : Shape::Node {
    Cylinder(Real r, Real half, Real round) : radius(r), half_height(half), rounding(round) {}
    Real distance(const Vec3& x) const override {
        const Real a = length_of(x.x(), x.y()) - (radius - rounding), b = std::abs(x.z()) - (half_height - rounding);
        return length_of(std::max(a, Real(0)), std::max(b, Real(0))) + std::min(std::max(a, b), Real(0)) - rounding;
    }
    std::optional<Box3> bounds() const override {
        const Vec3 half(radius, radius, half_height);
        return Box3{-half, half};
    }
    std::optional<TriangleMesh> exact_mesh(int segments) const override {
        return cylinder_mesh(radius, half_height, rounding, segments);
    }
    std::shared_ptr<const FaceTree> faces(Real by) const override {
        if (rounding + by > 0) return nullptr;
        FaceTree tree{FaceTree::Op::all};
        tree.parts.push_back(FaceTree::leaf(Shape(std::make_shared<Tube>(radius + by))));
        for (const double side : {1.0, -1.0})
            tree.parts.push_back(FaceTree::leaf(plane(side * Vec3d::UnitZ(), static_cast<double>(half_height + by))));
        return std::make_shared<FaceTree>(std::move(tree));
    }
    Real radius, half_height, rounding;
};

/// The convex hull of two spheres on the z axis, at 0 and at height. Where one contains the other it is the larger one.
struct RoundedCone final : Shape::Node {
    RoundedCone(Real r1, Real r2, Real h) : radius1(r1), radius2(r2), height(h), sine((r1 - r2) / h) {
        cosine = std::abs(sine) < 1 ? std::sqrt(1 - sine * sine) : 0;
    }
    Real distance(const Vec3& x) const override {
        const Real r = length_of(x.x(), x.y());
        const Real d1 = length_of(r, x.z()) - radius1, d2 = length_of(r, x.z() - height) - radius2;
        if (cosine == 0) return sine > 0 ? d1 : d2;
        // The place along the slanted side, measured from the tangent point on the first sphere.
        const Real along = x.z() * cosine - r * sine;
        if (along <= 0) return d1;
        if (along >= height * cosine) return d2;
        return r * cosine + x.z() * sine - radius1;
    }
    std::optional<Box3> bounds() const override {
        const Real r = std::max(radius1, radius2);
        return Box3{Vec3(-r, -r, std::min(-radius1, height - radius2)),
                    Vec3(r, r, std::max(radius1, height + radius2))};
    }
    std::optional<TriangleMesh> exact_mesh(int segments) const override {
        return rounded_cone_mesh(radius1, radius2, height, segments);
    }
    Real radius1, radius2, height, sine, cosine;
};

struct Torus final : Shape::Node {
    Torus(Real r, Real t) : radius(r), tube(t) {}
    Real distance(const Vec3& x) const override {
        const Real a = length_of(x.x(), x.y()) - radius;
        return length_of(a, x.z()) - tube;
    }
    std::optional<Box3> bounds() const override {
        const Vec3 half(radius + tube, radius + tube, tube);
        return Box3{-half, half};
    }
    std::optional<TriangleMesh> exact_mesh(int segments) const override { return torus_mesh(radius, tube, segments); }
    Real radius, tube;
};

struct Plane final : Shape::Node, SlopedNode {
    Plane(const Vec3& n, Real o) : normal(n), offset(o) {}
    Real distance(const Vec3& x) const override { return normal.dot(x) - offset; }
    Real sloped(const Vec3& x, Real, Vec3& slope) const override {
        slope = normal;
        return distance(x);
    }
    std::optional<Box3> bounds() const override { return std::nullopt; }
    Vec3 normal;
    Real offset;
};

void check_rounding(double rounding, double smallest_half, const char* what) {
    size_not_negative(rounding, what);
    if (rounding > smallest_half)
        throw InputError("{} is {}; it must not exceed half the smallest extent, {}", what, rounding, smallest_half);
}

}  // namespace

Shape sphere(double radius) { return Shape(std::make_shared<Sphere>(Real(positive_size(radius, "sphere radius")))); }

Shape box(const Vec3d& size, double rounding) {
    for (int k = 0; k < 3; ++k) positive_size(size[k], "box size");
    check_rounding(rounding, size.minCoeff() / 2, "box rounding");
    return Shape(std::make_shared<Box>((size / 2).cast<Real>(), Real(rounding)));
}

Shape cylinder(double radius, double height, double rounding) {
    positive_size(radius, "cylinder radius");
    positive_size(height, "cylinder height");
    check_rounding(rounding, std::min(radius, height / 2), "cylinder rounding");
    return Shape(std::make_shared<Cylinder>(Real(radius), Real(height / 2), Real(rounding)));
}

Shape rounded_cone(double radius1, double radius2, double height) {
    positive_size(radius1, "rounded_cone radius1");
    positive_size(radius2, "rounded_cone radius2");
    positive_size(height, "rounded_cone height");
    return Shape(std::make_shared<RoundedCone>(Real(radius1), Real(radius2), Real(height)));
}

Shape capsule(const Vec3d& from, const Vec3d& to, double radius) {
    finite_vector(from, "capsule from");
    finite_vector(to, "capsule to");
    positive_size(radius, "capsule radius");
    const Vec3d axis = to - from;
    if (axis.norm() < 1e-12 * radius) return translated(sphere(radius), from);
    const Quatd turn = Quatd::FromTwoVectors(Vec3d::UnitZ(), axis);
    return transformed(rounded_cone(radius, radius, axis.norm()), 1, turn, from);
}

Shape torus(double radius, double tube) {
    positive_size(radius, "torus radius");
    positive_size(tube, "torus tube");
    if (tube > radius) throw InputError("torus tube is {}; it must not exceed the torus radius, {}", tube, radius);
    return Shape(std::make_shared<Torus>(Real(radius), Real(tube)));
}

Shape plane(const Vec3d& normal, double offset) {
    finite_vector(normal, "plane normal");
    finite_number(offset, "plane offset");
    const double length = normal.norm();
    if (!(length > 0)) throw InputError("plane normal is zero; give the direction out of the solid");
    return Shape(std::make_shared<Plane>((normal / length).cast<Real>(), Real(offset)));
}

}  // namespace thixo
