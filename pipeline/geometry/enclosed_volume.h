// The volume that a closed cloud of surfels encloses.
#pragma once

#include <functional>
#include <span>

#include "pipeline/base/math.h"

namespace thixo {

/// Volume [m^3] inside the implicit surface of the surfels: a grid of cells of half the support, each counted by how
/// far its centre lies below the surface (F, freed of its leading error by curvature). Where surfels face away from
/// each other, as in thin sheets and small drops, the two sides have an F each, and cells are halved. Cells outside all
/// supports are settled by flood fill: what is joined to the border is outside, a closed-off region takes the side its
/// rim is on. A cavity, whose surfels point into it, is not counted. `groups` separates bodies, whose volumes are
/// summed; it may be empty. Where a `room` is given (signed distance [m], > 0 inside; asked near the surface only),
/// what lies outside of it does not count. Within 0.5 % on spheres and tori whose curvature radius is a few supports, 5
/// % on sheets half as thick as surfels are apart, 8 % on drops with a radius of half a support. Requires closed
/// surfaces; support h_s > 0 [m]. Throws ResourceError where they are spread over more than 2^30 cells.
double enclosed_volume(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support,
                       std::span<const std::int32_t> groups = {}, const std::function<Real(const Vec3&)>& room = {});

}  // namespace thixo
