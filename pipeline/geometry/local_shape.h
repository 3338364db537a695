// Faster evaluation of shapes with many parts: in a small ball, or in a block, few parts matter.
#pragma once

#include <memory>
#include <optional>

#include "pipeline/geometry/shape.h"

namespace thixo {

struct Ball3 {
    Vec3 centre{0, 0, 0};
    Real radius = 0;
};

/// A node with several parts that can tell which of them matter in a ball.
struct PartedNode {
    virtual ~PartedNode() = default;
    /// A shape with fewer parts and the same distance at every point of the ball; empty where no part can be left out.
    /// This holds because a distance changes by no more than the point moves.
    virtual std::optional<Shape> within(const Ball3& ball) const = 0;
};

/// The same for any shape.
std::optional<Shape> parts_within(const Shape& shape, const Ball3& ball);

/// A copy of a node that transforms one shape, with the parts that matter in the ball. The ball is given in the space
/// of that shape.
template <class N>
std::optional<Shape> with_parts_within(const N& node, const Ball3& ball) {
    auto inner = parts_within(node.shape, ball);
    if (!inner) return std::nullopt;
    auto copy = std::make_shared<N>(node);
    copy->shape = *std::move(inner);
    return Shape(std::move(copy));
}

/// A shape with the same distance everywhere that is faster near its surface. Cubic blocks of about the edge `block`
/// [m], at least 1/64 of the extent, evaluate only the parts that matter in them. This pays for shapes of many parts
/// that are evaluated many times per block. A shape that has no bounds, or that no block can simplify, is returned
/// unchanged. Throws InputError where block <= 0.
Shape by_blocks(const Shape& shape, double block);

}  // namespace thixo
