// The broad phase of contact: pairs of bodies that may touch.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "sim/state/solids.h"

namespace thixo {

/// A body in the broad phase.
struct Extent {
    Box3 box;            // of its elements
    Vec3 mean{0, 0, 0};  // mean velocity [m/s]
    Real spread = 0;     // largest speed relative to the mean [m/s]
    Real shift = 0;      // largest displacement [m]
    Real width = 0;      // of an element [m]
};

/// The extent of a body. Writes the places of its elements in the world into `place`.
Extent extent_of(const SolidBody& body, const BodyPose& pose, const Elements& e, std::vector<Vec3>& place);

/// Builds the grid of a body's elements, Contacts::grid, at the places that extent_of has written (Contacts::place).
void build_grid(std::int32_t body, Solids& solids);

/// Gap between two boxes along the axis on which they are farthest apart; < 0: they overlap [m].
inline Real gap_of(const Box3& a, const Box3& b) { return (a.lower - b.upper).cwiseMax(b.lower - a.upper).maxCoeff(); }
inline bool holds(const Box3& box, Real by, const Vec3& x) {
    return ((x - box.lower).array() > -by).all() && ((box.upper - x).array() > -by).all();
}

/// Pairs (a, b) of boxes that touch, a < b, ascending. A sweep along the axis on which the boxes' centres spread most
/// finds them: nearly linear where few overlap along that axis. Empty boxes (lower > upper) touch nothing.
std::vector<std::pair<std::int32_t, std::int32_t>> touching_pairs(const std::vector<Box3>& boxes);

/// The boxes that touch each box, ascending: `partner` from begin[k] to begin[k + 1].
struct Partners {
    std::vector<std::size_t> begin;  // of each box, then the end
    std::vector<std::int32_t> partner;
    std::span<const std::int32_t> of(std::size_t box) const {
        return std::span(partner).subspan(begin[box], begin[box + 1] - begin[box]);
    }
};
Partners touching_partners(const std::vector<Box3>& boxes);

}  // namespace thixo
