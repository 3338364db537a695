// Evaluates a boolean tree of sheets where the side of some sheets is not certain.
#pragma once

namespace thixo {

/// A set of outcomes: every value that a part of the tree can take over all choices of the uncertain sides.
enum Outcome : unsigned {
    kOutside = 1,  ///< false
    kInside = 2,   ///< true
    kOwnSide = 4   ///< equal to the side of the sheet in question
};

/// Outcomes of a tree of unions and intersections. leaf(node) gives the outcomes of a leaf. The set is exact where
/// every sheet occurs once. A leaf type may have a function holds(node): where it is true, the node is inside.
template <class Tree, class Leaf>
unsigned outcomes(const Tree& tree, Leaf&& leaf) {
    if constexpr (requires { leaf.holds(tree); })
        if (leaf.holds(tree)) return kInside;
    if (tree.parts.empty()) return leaf(tree);
    const bool any = tree.op == Tree::Op::any;
    // In a union, inside of one part decides, and outside of one part leaves the decision to the others. In an
    // intersection the two are exchanged.
    const unsigned settles = any ? kInside : kOutside, yields = any ? kOutside : kInside;
    unsigned result = yields;
    for (const Tree& part : tree.parts) {
        const unsigned other = outcomes(part, leaf);
        unsigned both = (result | other) & settles;
        if (result & yields) both |= other;
        if (other & yields) both |= result;
        both |= result & other & kOwnSide;
        if ((result = both) == settles) break;
    }
    return result;
}

/// The outcomes of another sheet's side. Its signed distance d is uncertain by `tolerance`.
template <class Number>
unsigned outcome_of_side(Number d, Number tolerance) {
    return (d < tolerance ? kInside : 0u) | (d > -tolerance ? kOutside : 0u);
}

}  // namespace thixo
