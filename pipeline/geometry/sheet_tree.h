// The boolean tree over the sheets of a sampled surface, which says what parts of the sheets bound the body.
#pragma once

#include <vector>

namespace thixo {

/// A sheet represents the region behind it, where its signed distance is negative. all: behind all parts; any: behind
/// any of them. A part of a sheet bounds the body where the tree changes with the side of that sheet. The normals of
/// all surfels point out of the body, so that there are no differences.
struct SheetTree {
    enum class Op { sheet, all, any };
    Op op = Op::sheet;
    int number = 0;                  // of Op::sheet
    std::vector<SheetTree> parts{};  // of the others, at least one
};

}  // namespace thixo
