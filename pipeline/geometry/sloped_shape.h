// Shapes that know the gradient of their distance.
#pragma once

#include "pipeline/geometry/shape.h"

namespace thixo {

/// What a node can tell that knows the derivative of its distance.
struct SlopedNode {
    virtual ~SlopedNode() = default;
    /// The distance at x, and in `slope` its gradient; where there is none (in an edge), that of one side. `step` [m]:
    /// of differences, for parts that do not know it.
    virtual Real sloped(const Vec3& x, Real step, Vec3& slope) const = 0;
};

/// A shape asked for its gradient often.
class SlopedShape : public Shape {
  public:
    SlopedShape(Shape shape) : Shape(std::move(shape)), known_(dynamic_cast<const SlopedNode*>(&node())) {}
    /// Distance and gradient: exact where the shape knows them; else by distances at four places around x, their mean
    /// for the distance (off by the second order of `step`).
    Real sloped(const Vec3& x, Real step, Vec3& slope) const {
        return known_ ? known_->sloped(x, step, slope) : by_differences(node(), x, step, slope);
    }
    bool knows_slope() const { return known_; }
    static Real by_differences(const Node& node, const Vec3& x, Real step, Vec3& slope);

  private:
    const SlopedNode* known_;  // the node
};

}  // namespace thixo
