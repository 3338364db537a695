// The faces of a solid of revolution, by cutting its profile at the corners.
#pragma once

#include <memory>
#include <vector>

#include "pipeline/geometry/face_tree.h"

namespace thixo {

/// Corners of a profile that turn by more than this angle make a sharp edge [degrees].
inline constexpr double kSharpTurn = 30;

/// The faces of the solid of revolution, offset outwards by `by` [m]. The profile runs counter-clockwise in (r, z),
/// with r >= 0. It is cut at the sharp corners that the offset does not round. Further cuts let a tree use every piece
/// once (Dobkin et al. 1988): a chain is cut at corners of its convex hull. Cuts at convex corners make intersections,
/// cuts at other corners make unions. Null where only one piece remains.
std::shared_ptr<const FaceTree> revolve_faces(const std::vector<Vec2d>& profile, Real by);

}  // namespace thixo
