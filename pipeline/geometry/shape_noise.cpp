// A shape whose surface is raised by noise.
#include <cmath>

#include "pipeline/geometry/bounds.h"
#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/gradient_noise.h"
#include "pipeline/geometry/local_shape.h"
#include "pipeline/geometry/shape_checks.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

// Bounds of gradient noise: over 6 * 10^6 places its magnitude is below 1.005 and its slope below 3.23.
constexpr Real kMostNoise = Real(1.05), kMostSlope = Real(3.4);

struct Roughness {
    Real amplitude, scale;
    int octaves;
    Real most() const { return std::abs(amplitude) * kMostNoise * Real(2 - std::ldexp(1.0, 1 - octaves)); }
    /// The greatest slope of distance minus noise.
    Real slope() const { return 1 + std::abs(amplitude) / scale * kMostSlope * Real(octaves); }
    Real height(const Vec3& x) const {
        return amplitude * Real(fractal_noise_value((x / scale).cast<float>(), octaves));
    }
};

/// The distance of the raised surface, a lower bound:
///     (distance - noise) / slope  [m]
/// A shape with edges takes its distance from the tree of its faces. Its raised faces then stay faces.
struct Rough final : Shape::Node, PartedNode, SlopedNode {
    Rough(Shape s, const Roughness& r, Real by_)
        : shape(std::move(s)), tree(shape.node().faces(by_)), roughness(r), by(by_), inverse_slope(1 / r.slope()) {
        if (const auto inner = shape.bounds()) box = grown(*inner, r.most() + std::max(by, Real(0)));
    }
    Real distance(const Vec3& x) const override {
        const Real outside = box ? distance_to(*box, x) : 0;
        const Real smooth = tree ? tree_distance(*tree, x) : shape.distance(x) - by;
        const Real d = (smooth - roughness.height(x)) * inverse_slope;
        return outside > 0 ? std::max(d, outside) : d;
    }
    Real sloped(const Vec3& x, Real step, Vec3& slope) const override {
        if (tree) return SlopedShape::by_differences(*this, x, step, slope);
        const Real smooth = shape.sloped(x, step, slope) - by;
        const NoiseSample noise = fractal_noise((x / roughness.scale).cast<float>(), roughness.octaves);
        slope -= roughness.amplitude / roughness.scale * noise.gradient.cast<Real>();
        slope *= inverse_slope;
        const Real d = (smooth - roughness.amplitude * Real(noise.value)) * inverse_slope;
        return box ? out_of_box(*box, x, d, slope) : d;
    }
    /// A tree of faces is evaluated in place of the shape.
    std::optional<Shape> within(const Ball3& ball) const override {
        return tree ? std::nullopt : with_parts_within(*this, ball);
    }
    std::optional<Box3> bounds() const override { return box; }
    std::shared_ptr<const FaceTree> faces(Real more) const override {
        const Real total = by + more * roughness.slope();
        const auto inner = shape.node().faces(total);
        if (!inner) return nullptr;
        return std::make_shared<FaceTree>(mapped(
            *inner, [&](const Shape& face) { return Shape(std::make_shared<Rough>(face, roughness, Real(0))); }));
    }
    std::optional<Vec3f> colour(const Vec3& x) const override { return shape.node().colour(x); }
    SlopedShape shape;
    std::shared_ptr<const FaceTree> tree;
    Roughness roughness;
    Real by, inverse_slope;
    std::optional<Box3> box;
};

}  // namespace

Shape roughened(Shape shape, double amplitude, double scale, int octaves) {
    finite_number(amplitude, "noise amplitude");
    positive_size(scale, "noise scale");
    if (octaves < 1 || octaves > 12) throw InputError("noise octaves are {}; use 1 to 12", octaves);
    return Shape(std::make_shared<Rough>(std::move(shape), Roughness{Real(amplitude), Real(scale), octaves}, Real(0)));
}

}  // namespace thixo
