// What a boolean tree of sheets does with one of them where the sides of some others are not certain.
#pragma once

namespace thixo {

/// A set of the ways a part of the tree can come out, over all choices of what is not certain.
enum Outcome : unsigned {
    kOutside = 1,  ///< false
    kInside = 2,   ///< true
    kOwnSide = 4   ///< as the sheet in question: its own side decides
};

/// Outcomes of a tree of unions and intersections, leaf(node) being those of its leaves. Exact where every sheet occurs
/// once.
template <class Tree, class Leaf>
unsigned outcomes(const Tree& tree, Leaf&& leaf) {
    if (tree.parts.empty()) return leaf(tree);
    const bool any = tree.op == Tree::Op::any;
    // In a union what is inside any part is inside, and what is outside of one part is as the others; in an
    // intersection the other way round.
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

/// The outcomes of another sheet's side at signed distance d, uncertain to `tolerance`.
template <class Number>
unsigned outcome_of_side(Number d, Number tolerance) {
    return (d < tolerance ? kInside : 0u) | (d > -tolerance ? kOutside : 0u);
}

}  // namespace thixo
