// A solid with sharp edges as a boolean tree of solids with smooth surfaces. These are its faces, extended beyond their
// edges.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/geometry/boolean_tree.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

/// face: a smooth solid; all: the intersection of the parts; any: their union; except: the first without the others.
/// Faces are numbered in depth-first order (number_faces).
struct FaceTree {
    enum class Op { face, all, any, except };
    Op op = Op::face;
    std::optional<Shape> face{};  // of Op::face
    int number = 0;               // of Op::face
    std::vector<FaceTree> parts{};

    static FaceTree leaf(Shape shape) { return {Op::face, std::move(shape), 0, {}}; }
    static FaceTree of(Op op, std::vector<FaceTree> parts) {
        return parts.size() == 1 ? std::move(parts[0]) : FaceTree{op, std::nullopt, 0, std::move(parts)};
    }
};

/// The faces of the solid distance < by [m]: those that its node gives, or the solid itself.
FaceTree faces_of(const Shape& shape, Real by = 0);

/// The tree of the complement, by De Morgan's laws; faces are inverted.
FaceTree complement(const FaceTree& tree);

/// The tree with f(face) in place of every face.
template <class F>
FaceTree mapped(FaceTree tree, F&& f) {
    if (tree.op == FaceTree::Op::face) tree.face = f(*tree.face);
    for (FaceTree& part : tree.parts) part = mapped(std::move(part), f);
    return tree;
}

/// The same solid by unions and intersections alone. Subtracted faces are inverted, so that all faces point out of it.
FaceTree without_differences(const FaceTree& tree);

/// Numbers the faces from 0 on in depth-first order and returns them in that order.
std::vector<Shape> number_faces(FaceTree& tree);

/// The value of a tree without differences, where inside(k) tells on which side of face k a point lies.
template <class Tree, class Inside>
bool evaluate(const Tree& tree, Inside&& inside) {
    using Op = typename Tree::Op;
    if (tree.parts.empty()) return inside(tree.number);
    for (const Tree& part : tree.parts)
        if (evaluate(part, inside) == (tree.op == Op::any)) return tree.op == Op::any;
    return tree.op != Op::any;
}

/// Whether a point of face `own` lies on the boundary of a tree without differences. There the tree's value changes
/// with the side of that face. The point's signed distance to face k is distance(k). A point nearer than `tolerance`
/// [m] counts for the side that makes a boundary, so that all of several coinciding faces are boundaries.
template <class Tree, class Distance>
bool bounds_solid(const Tree& tree, int own, Real tolerance, Distance&& distance) {
    return outcomes(tree,
                    [&](const Tree& leaf) {
                        return leaf.number == own ? unsigned(kOwnSide)
                                                  : outcome_of_side(distance(leaf.number), tolerance);
                    }) &
           kOwnSide;
}

/// Distance by minima and maxima of the faces' distances: it has the sign of the solid's, and their smoothness.
Real tree_distance(const FaceTree& tree, const Vec3& x);

}  // namespace thixo
