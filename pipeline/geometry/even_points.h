// Even subsets of random points on a surface.
#pragma once

#include <span>
#include <vector>

#include "pipeline/geometry/face_points.h"

namespace thixo {

/// Weighted sample elimination (Yuksel 2015): removes the most crowded point until `count` points remain. Returns their
/// indices, ascending. A point at distance d adds to the crowding, with r the distance of a hexagonal lattice [m], by
///     (1 - d/(2 r))^8
/// Points whose normals are more than 90 degrees apart lie on two sides and do not crowd each other. `spacing` [m] is
/// the root of the area per remaining point.
std::vector<Index> even_subset(std::span<const Vec3> positions, std::span<const Vec3> normals, std::size_t count,
                               Real spacing);

/// Pushes the points of a face apart along it. Every sweep moves each point by the sum of its neighbours' repulsions
///     (1 - d/R)^2
/// and brings it back near the face; the last sweeps bring it onto the face. Points with `fixed` are only brought onto
/// the face.
void relax(const Face& face, std::vector<Vec3>& positions, std::vector<Vec3>& normals, const std::vector<char>& fixed,
           Real spacing, int sweeps);

}  // namespace thixo
