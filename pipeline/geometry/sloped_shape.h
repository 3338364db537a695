// Shapes whose distance has a known gradient.
#pragma once

#include "pipeline/geometry/shape.h"

namespace thixo {

/// A node that can evaluate the gradient of its distance.
struct SlopedNode {
    virtual ~SlopedNode() = default;
    /// The distance at x [m], and its gradient in `slope`. On an edge, where there is no gradient, it is that of one
    /// side. `step` [m] is the width of differences for parts without a known gradient.
    virtual Real sloped(const Vec3& x, Real step, Vec3& slope) const = 0;
};

/// A shape whose gradient is evaluated often.
class SlopedShape : public Shape {
  public:
    SlopedShape(Shape shape) : Shape(std::move(shape)), known_(dynamic_cast<const SlopedNode*>(&node())) {}
    /// Distance and gradient, exact where the shape can give both. Otherwise they come from distances at four places
    /// around x; their mean is the distance, with an error of second order in `step`.
    Real sloped(const Vec3& x, Real step, Vec3& slope) const {
        return known_ ? known_->sloped(x, step, slope) : by_differences(node(), x, step, slope);
    }
    bool knows_slope() const { return known_; }
    static Real by_differences(const Node& node, const Vec3& x, Real step, Vec3& slope);

  private:
    const SlopedNode* known_;  // the node
};

}  // namespace thixo
