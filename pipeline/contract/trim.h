// Which parts of a body's sheets bound it: a boolean tree over them (dissertation 5.6.3; Wicke et al. 2004).
#pragma once

#include <vector>

namespace thixo {

/// A sheet stands for the half of space behind it, where its signed distance is negative. all: behind all parts; any:
/// behind any of them; except: behind the first and none of the others. A part of a sheet bounds the body where the
/// tree changes with the side of that sheet.
struct TrimNode {
    enum class Op { sheet, all, any, except };
    Op op = Op::sheet;
    int sheet = 0;               // of Op::sheet; the surfels' attribute `sheet`
    std::vector<TrimNode> parts;  // of the others, at least one
};

}  // namespace thixo
