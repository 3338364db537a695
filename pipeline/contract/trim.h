// Which parts of a body's sheets bound it: a boolean tree over them (dissertation 5.6.3; Wicke et al. 2004).
#pragma once

#include <cstdint>
#include <vector>

namespace thixo {

/// Surfels' attribute `sheet`: from here on they are faces of cracks. No shape has as many sheets.
inline constexpr std::int32_t kFirstCrackSheet = 1 << 20;

/// A sheet stands for the half of space behind it, where its signed distance is negative. The operators:
///
///     all      behind all parts
///     any      behind any of them
///     except   behind the first and none of the others
///
/// A part of a sheet bounds the body where the tree's answer changes from one side of that sheet to the other.
struct TrimNode {
    enum class Op { sheet, all, any, except };
    Op op = Op::sheet;
    int sheet = 0;                // of Op::sheet; the surfels' attribute `sheet`
    std::vector<TrimNode> parts;  // of the others, at least one
    // Above 0: the node holds wherever none of its sheets has a surfel nearer than this. A crack so trims what is beside
    // it, and nothing else [m].
    float reach = 0;
};

inline TrimNode sheet_node(int sheet) { return {TrimNode::Op::sheet, sheet, {}, 0}; }

/// The same tree from another type of that form, whose leaves have a `number` (SheetTree of pipeline/geometry).
template <class Tree>
TrimNode trim_node(const Tree& tree) {
    if (tree.parts.empty()) return sheet_node(tree.number);
    TrimNode node{tree.op == Tree::Op::any ? TrimNode::Op::any : TrimNode::Op::all, 0, {}, 0};
    for (const Tree& part : tree.parts) node.parts.push_back(trim_node(part));
    return node;
}

}  // namespace thixo
