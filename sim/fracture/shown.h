// What frames show of cracks, beside their faces: how near matter is to breaking, and where fronts are.
#pragma once

#include <vector>

#include "sim/state/solids.h"

namespace thixo {

/// By element, in the order of Elements.
struct ShownStress {
    std::vector<float> load;  // largest tension over strength; 0 where nothing pulls, or the matter never breaks [1]
    std::vector<float> von_mises;  // of the stress of find_stress (tension.h) [Pa]
};
/// Of the present displacement. Requires laws of the present time.
ShownStress shown_stress(const Solids& solids);

/// A front in the world.
struct ShownFront {
    bool closed = false;
    std::vector<Vec3> nodes;  // [m]
};
/// Where fronts are at present. One that runs through several pieces is shown as a line in each. A node at m of the
/// material frame is carried by the elements j about it, of the piece of the nearest one:
///     x = sum_j w_poly6(m - m_j, h) (m + u_j + H_j (m - m_j)) / sum_j w_poly6(m - m_j, h)      [m]
/// and then by the pose of that piece.
std::vector<ShownFront> shown_fronts(const Solids& solids);

}  // namespace thixo
