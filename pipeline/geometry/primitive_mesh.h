// Meshes of primitives from their own description, with exact positions and smooth or sharp normals.
#pragma once

#include <vector>

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// A closed polygon (r >= 0, z), counter-clockwise, rotated about z in `segments` steps. Corners that turn by more than
/// 40 degrees stay sharp (doubled vertices). At a smooth corner between edges of similar length, the normal is that of
/// the circle through the neighbours. An edge more than three times as long as the other is a flat part beside a
/// rounding, and the corner takes its normal.
TriangleMesh lathe_mesh(const std::vector<Vec2d>& profile, int segments);

TriangleMesh sphere_mesh(double radius, int segments);
TriangleMesh cylinder_mesh(double radius, double half_height, double rounding, int segments);
TriangleMesh rounded_cone_mesh(double radius1, double radius2, double height, int segments);
TriangleMesh torus_mesh(double radius, double tube, int segments);
/// The box with half edges `core`, offset outwards by `rounding`.
TriangleMesh box_mesh(const Vec3& core, double rounding, int segments);

}  // namespace thixo
