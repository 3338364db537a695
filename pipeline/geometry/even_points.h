// Even subsets of random points on a surface.
#pragma once

#include <span>
#include <vector>

#include "pipeline/geometry/face_points.h"

namespace thixo {

/// Indices of the `count` points, ascending, that are left when the most crowded is taken away again and again
/// (weighted sample elimination, Yuksel 2015: weights (1 - d/(2 r))^8, r the distance of a hexagonal lattice). Points
/// whose normals are more than 90 degrees apart do not see each other: they lie on two sides. `spacing` [m]: the root
/// of the area per point that is left.
std::vector<Index> even_subset(std::span<const Vec3> positions, std::span<const Vec3> normals, std::size_t count,
                               Real spacing);

/// Pushes points of a face apart along it: every sweep moves each by the sum of its neighbours' repulsion (1 - d/R)^2
/// and brings it back near the face, the last ones onto it. Points with `fixed` stay but for being brought onto it.
void relax(const Face& face, std::vector<Vec3>& positions, std::vector<Vec3>& normals, const std::vector<char>& fixed,
           Real spacing, int sweeps);

}  // namespace thixo
