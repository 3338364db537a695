// Lines in a picture: dark strokes become polylines through their middles.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/base/math.h"

namespace thixo {

/// Which pixels of a picture are of lines, row by row from the top left.
struct LineMask {
    int width = 0, height = 0;
    std::vector<std::uint8_t> dark;  // 1: of a line
    bool at(int x, int y) const {
        return x >= 0 && y >= 0 && x < width && y < height &&
               dark[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] != 0;
    }
};

/// Thins strokes to lines of one pixel that are connected as the strokes are (Zhang & Suen 1984, A fast parallel
/// algorithm for thinning digital patterns). Pixels that alone make a line thicker than one are taken out besides.
LineMask thinned(LineMask mask);

/// A line through pixel middles, in pixels from the top left corner of the picture. A ring ends where it began.
using PixelLine = std::vector<Vec2d>;

/// The lines of a thinned picture: branches from one end or junction to the next, and rings. Neighbouring pixels with three branches or
/// more are one junction. Branches that end freely and are shorter than `shortest` [pixels] are spurs of the thinning:
/// they are left out where they hang on a junction. Rings begin at their first pixel, row by row.
std::vector<PixelLine> trace_lines(const LineMask& thin, double shortest);

/// The line with as few of its points as stay within `off` [pixels] of all (Douglas & Peucker 1973).
PixelLine simplified(const PixelLine& line, double off);

}  // namespace thixo
