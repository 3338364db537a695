// Shapes of many parts where few of them matter: in a small ball, and block by block.
#pragma once

#include <memory>
#include <optional>

#include "pipeline/geometry/shape.h"

namespace thixo {

struct Ball3 {
    Vec3 centre{0, 0, 0};
    Real radius = 0;
};

/// What a node can tell that asks several parts: which of them matter in a ball.
struct PartedNode {
    virtual ~PartedNode() = default;
    /// A shape of the same distance at every point of the ball that asks fewer parts; empty where none can be left out.
    /// Rests on distances changing by no more than the point moves.
    virtual std::optional<Shape> within(const Ball3& ball) const = 0;
};

/// The same of any shape.
std::optional<Shape> parts_within(const Shape& shape, const Ball3& ball);

/// A copy of a node that changes one shape, for what matters in the ball, told in that shape's own space.
template <class N>
std::optional<Shape> with_parts_within(const N& node, const Ball3& ball) {
    auto inner = parts_within(node.shape, ball);
    if (!inner) return std::nullopt;
    auto copy = std::make_shared<N>(node);
    copy->shape = *std::move(inner);
    return Shape(std::move(copy));
}

/// The shape with the same distance everywhere, quicker near its surface: cubic blocks of about this edge [m], not
/// under 1/64 of its extent, ask only the parts that matter in them. Pays for shapes of many parts asked many times a
/// block; one that leaves nothing out anywhere, or has no bounds, is returned as it is. Throws InputError where block
/// <= 0.
Shape by_blocks(const Shape& shape, double block);

}  // namespace thixo
