// The faces of a solid of revolution: its profile cut at the corners.
#pragma once

#include <memory>
#include <vector>

#include "pipeline/geometry/face_tree.h"

namespace thixo {

/// Corners of a profile that turn by more than this make an edge [degrees].
inline constexpr double kSharpTurn = 30;

/// The faces of the solid of revolution grown by `by` [m], profile counter-clockwise in (r, z), r >= 0. The profile is
/// cut at its sharp corners (those that growing does not round) and where else it must be to be written with every
/// piece used once: a chain is cut at corners of its convex hull, an intersection at convex ones, a union at others
/// (Dobkin et al. 1988). Null where that leaves one piece.
std::shared_ptr<const FaceTree> revolve_faces(const std::vector<Vec2d>& profile, Real by);

}  // namespace thixo
