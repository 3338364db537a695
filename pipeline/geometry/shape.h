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

/// An immutable shape; copies share the same tree. Exact distance for primitives; a lower bound of its magnitude for
/// combinations (as usual for signed-distance trees), with the sign always right. Where bounds exist, the distance
/// outside of them is never below the distance to that box. Constructors: shapes.h.
class Shape {
  public:
    struct Node {
        virtual ~Node() = default;
        virtual Real distance(const Vec3& x) const = 0;
        /// The distances of n points to `out`; quicker than one by one where each lies near the one before it.
        virtual void distances(const Vec3* x, Real* out, std::size_t n) const {
            for (std::size_t k = 0; k < n; ++k) out[k] = distance(x[k]);
        }
        /// Box that holds the inside and the surface; empty where the shape is unbounded (a plane, an inverted shape).
        virtual std::optional<Box3> bounds() const = 0;
        /// A closed mesh made from the shape's own description (corners, profile), `segments` around a full turn; empty
        /// where the shape has none and the surface must be extracted from the distance.
        virtual std::optional<TriangleMesh> exact_mesh(int /*segments*/) const { return std::nullopt; }
        /// The solid distance < by [m] as a boolean tree of solids with smooth surfaces; null where its own surface is
        /// smooth, or where nothing is known of its edges.
        virtual std::shared_ptr<const FaceTree> faces(Real /*by*/) const { return nullptr; }
        /// Colour (linear) of the surface near x; empty where the shape has none of its own.
        virtual std::optional<Vec3f> colour(const Vec3& /*x*/) const { return std::nullopt; }
        /// The surface itself, where the shape is made of one (a mesh); null for all others.
        virtual std::shared_ptr<const DirectSurface> direct_surface() const { return nullptr; }
        /// A surfel for every point of a point set or vertex of a mesh; null for all other shapes.
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
