// Which sheets of surfels bound a body: the boolean tree a sampled surface comes with.
#pragma once

#include <vector>

namespace thixo {

/// A sheet stands for the half of space behind it, where its signed distance is negative. all: behind all parts; any:
/// behind any of them. A part of a sheet bounds the body where the tree changes with the side of that sheet. Every
/// surfel's normal leads out of the body, so that there are no differences.
struct SheetTree {
    enum class Op { sheet, all, any };
    Op op = Op::sheet;
    int number = 0;                  // of Op::sheet
    std::vector<SheetTree> parts{};  // of the others, at least one
};

}  // namespace thixo
