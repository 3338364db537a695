#include "pipeline/geometry/face_tree.h"

#include <algorithm>

#include "pipeline/geometry/shapes.h"

namespace thixo {

FaceTree faces_of(const Shape& shape, Real by) {
    if (const auto faces = shape.node().faces(by)) return *faces;
    return FaceTree::leaf(by == 0 ? shape : offset(shape, static_cast<double>(by)));
}

FaceTree complement(const FaceTree& tree) {
    using Op = FaceTree::Op;
    if (tree.op == Op::face) return FaceTree::leaf(inverted(*tree.face));
    FaceTree result;
    result.op = tree.op == Op::any ? Op::all : Op::any;
    for (std::size_t k = 0; k < tree.parts.size(); ++k)
        result.parts.push_back(tree.op == Op::except && k > 0 ? tree.parts[k] : complement(tree.parts[k]));
    return result;
}

FaceTree without_differences(const FaceTree& tree) {
    using Op = FaceTree::Op;
    if (tree.op == Op::face) return tree;
    FaceTree result;
    result.op = tree.op == Op::any ? Op::any : Op::all;
    for (std::size_t k = 0; k < tree.parts.size(); ++k)
        result.parts.push_back(
            without_differences(tree.op == Op::except && k > 0 ? complement(tree.parts[k]) : tree.parts[k]));
    return result;
}

namespace {

void number(FaceTree& tree, std::vector<Shape>& faces) {
    if (tree.op == FaceTree::Op::face) {
        tree.number = static_cast<int>(faces.size());
        faces.push_back(*tree.face);
    }
    for (FaceTree& part : tree.parts) number(part, faces);
}

}  // namespace

std::vector<Shape> number_faces(FaceTree& tree) {
    std::vector<Shape> faces;
    number(tree, faces);
    return faces;
}

Real tree_distance(const FaceTree& tree, const Vec3& x) {
    using Op = FaceTree::Op;
    if (tree.op == Op::face) return tree.face->distance(x);
    Real d = tree_distance(tree.parts[0], x);
    for (std::size_t k = 1; k < tree.parts.size(); ++k) {
        const Real part = tree_distance(tree.parts[k], x);
        d = tree.op == Op::any ? std::min(d, part) : std::max(d, tree.op == Op::except ? -part : part);
    }
    return d;
}

}  // namespace thixo
