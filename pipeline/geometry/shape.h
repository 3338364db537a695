// Shapes as signed distance functions: negative inside, positive outside, in metres.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/geometry/mesh.h"

namespace thixo {

struct Box3 {
    Vec3 lower{0, 0, 0}, upper{0, 0, 0};
};

class DirectSurface;  // direct_surface.h
struct FaceTree;      // face_tree.h
struct PointSurfels;  // point_surfels.h

/// An immutable shape; copies share the same tree. The distance of primitives is exact. For combinations it is a lower
/// bound of the magnitude, as usual for trees of signed distances, and the sign is always right. Where bounds exist,
/// the distance outside them is never below the distance to that box. Constructors: shapes.h.
class Shape {
  public:
    struct Node {
        virtual ~Node() = default;
        virtual Real distance(const Vec3& x) const = 0;
        /// Writes the distances of n points to `out`. This is faster than one by one where consecutive points are near
        /// each other.
        virtual void distances(const Vec3* x, Real* out, std::size_t n) const {
            for (std::size_t k = 0; k < n; ++k) out[k] = distance(x[k]);
        }
        /// A box around the inside and the surface; empty where the shape is unbounded (a plane, an inverted shape).
        virtual std::optional<Box3> bounds() const = 0;
        /// A closed mesh from the shape's own description (corners, profile), with `segments` to a full turn. Empty
        /// where the surface must be extracted from the distance.
        virtual std::optional<TriangleMesh> exact_mesh(int /*segments*/) const { return std::nullopt; }
        /// The solid distance < by [m] as a boolean tree of solids with smooth surfaces. Null where its own surface is
        /// smooth, or where its edges are not known.
        virtual std::shared_ptr<const FaceTree> faces(Real /*by*/) const { return nullptr; }
        /// Colour (linear) of the surface near x; empty where the shape has none of its own.
        virtual std::optional<Vec3f> colour(const Vec3& /*x*/) const { return std::nullopt; }
        /// The surface itself, where the shape is made of one (a mesh); null for other shapes.
        virtual std::shared_ptr<const DirectSurface> direct_surface() const { return nullptr; }
        /// A surfel for every point of a point set or vertex of a mesh; null for other shapes.
        virtual std::shared_ptr<const PointSurfels> own_surfels() const { return nullptr; }
    };
    explicit Shape(std::shared_ptr<const Node> node) : node_(std::move(node)) {}
    Real distance(const Vec3& x) const { return node_->distance(x); }
    std::optional<Box3> bounds() const { return node_->bounds(); }
    /// Outward unit gradient of the distance by central differences of width `step` [m]; zero vector where it vanishes.
    Vec3 gradient(const Vec3& x, Real step) const;
    const Node& node() const { return *node_; }

  private:
    std::shared_ptr<const Node> node_;
};

}  // namespace thixo
