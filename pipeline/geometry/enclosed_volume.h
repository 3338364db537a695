// The volume that a closed cloud of surfels encloses.
#pragma once

#include <functional>
#include <span>

#include "pipeline/base/math.h"

namespace thixo {

/// Volume [m^3] inside the implicit surface of the surfels: a grid of cells of half the support, each counted by how
/// far its centre lies below the surface (F, freed of its leading error by curvature). Where surfels face away from each
/// other, as in thin sheets and small drops, the two sides have an F each, and cells are halved. Cells outside all supports are
/// settled by flood fill: what is joined to the border is outside, a closed-off region takes the side its rim is on. A
/// cavity, whose surfels point into it, is not counted. `groups` separates bodies, whose volumes are summed; it may be
/// empty. Within 0.5 % on spheres and tori whose curvature radius is a few supports. Requires closed surfaces; support
/// h_s > 0 [m].
double enclosed_volume(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support,
                       std::span<const std::int32_t> groups = {},
                       const std::function<Real(const Vec3&)>& room = {});

}  // namespace thixo
