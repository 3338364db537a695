// Contact's broad phase: which bodies may meet.
#pragma once

#include <utility>
#include <vector>

#include "sim/state/solids.h"

namespace thixo {

/// A body as the broad phase sees it.
struct Extent {
    Box3 box;            // of its elements
    Vec3 mean{0, 0, 0};  // velocity [m/s]
    Real spread = 0;     // largest speed against that [m/s]
    Real shift = 0;      // largest displacement [m]
    Real width = 0;      // of an element [m]
};

/// Writes the places of the body's elements in the world, too.
Extent extent_of(const SolidBody& body, const BodyPose& pose, const Elements& e, std::vector<Vec3>& place);

/// Gap between two boxes along the axis on which they are farthest apart; < 0: they overlap [m].
inline Real gap_of(const Box3& a, const Box3& b) { return (a.lower - b.upper).cwiseMax(b.lower - a.upper).maxCoeff(); }
inline bool holds(const Box3& box, Real by, const Vec3& x) {
    return ((x - box.lower).array() > -by).all() && ((box.upper - x).array() > -by).all();
}

/// Pairs (a, b), a < b, ascending, of boxes that touch. By a sweep along the axis on which the boxes' centres spread
/// most: near linear where few overlap along that axis. Empty boxes (lower > upper) touch nothing.
std::vector<std::pair<std::int32_t, std::int32_t>> touching_pairs(const std::vector<Box3>& boxes);

}  // namespace thixo
