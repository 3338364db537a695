// Blades: edges that move through solids and cut them. Dissertation 5.6.6.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/geometry/keyframes.h"

namespace thixo {

/// A blade, resolved at set-up, and the cut that it is making. Places of the cut are in the material frame of the scene
/// body.
struct Blade {
    std::int32_t source = 0;    // the scene body that it cuts
    std::vector<Vec3d> edge{};  // points, no farther apart than a row of the sheet, without the motion [m]
    Vec3d direction{0, 0, 0};   // unit, of the cut, without the motion
    RigidMotion motion{};
    double start = 0, stop = 0;  // [s]
    // State.
    std::int32_t crack = -1;      // its row in Cracks; -1: nothing is cut yet
    std::vector<Vec3> row{};      // the edge at the last row of the sheet; empty: it is far away [m]
    std::vector<Index> vertex{};  // of the sheet at these places; kNone outside of the body
    std::vector<Index> rim{};     // where the row leaves the body between points k and k + 1; kNone: it does not
    std::array<std::vector<Index>, 2> side{};  // ways of the edge's two ends through the body; kNone ends a stretch

    bool active(double time) const { return time >= start && time < stop; }
};

}  // namespace thixo
