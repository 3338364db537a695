// Surfels: oriented elliptical discs (notation: docs/notation.md). A disc consists of the points
//     s + a t1 + b t2,  a^2 + b^2 <= 1
#pragma once

#include <vector>

#include "pipeline/base/math.h"

namespace thixo {

/// A cloud of surfels as a structure of arrays; element k of every array is surfel k. All arrays have the same size.
struct SurfelCloud {
    std::vector<Vec3> position;  // s [m]
    std::vector<Vec3> axis1;     // t1 [m], tangent half-axis
    std::vector<Vec3> axis2;     // t2 [m], tangent half-axis
    std::vector<Vec3> normal;    // n = t1 x t2 / |t1 x t2| [1], outward
    std::size_t size() const { return position.size(); }
};

}  // namespace thixo
