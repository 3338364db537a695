// The volume that a closed cloud of surfels encloses.
#pragma once

#include <functional>
#include <span>

#include "pipeline/base/math.h"

namespace thixo {

/// Volume [m^3] inside the implicit surface of the surfels.
///
/// The surface is covered by a grid of cells of half the support. Each cell counts by how far its centre lies below the
/// surface: by F, freed of its leading error by curvature. In thin sheets and small drops surfels face away from each
/// other; there each side has an F of its own, and cells are halved. Flood fill decides the cells outside all supports.
/// Regions that are joined to the border are outside, and a closed region takes the side of its rim. A cavity, whose
/// surfels point into it, is not counted.
///
/// `groups` separates bodies, whose volumes are added; it may be empty. With a `room` only what lies inside it counts:
/// a signed distance [m], > 0 inside, which is evaluated near the surface only. The error is at most
///     0.5 %   on spheres and tori with a radius of curvature of a few supports
///     5 %     on sheets half as thick as the spacing of the surfels
///     8 %     on drops with a radius of half a support
/// Requires closed surfaces and a support h_s > 0 [m]. Throws ResourceError where they span more than 2^30 cells.
double enclosed_volume(std::span<const Vec3> positions, std::span<const Vec3> normals, Real support,
                       std::span<const std::int32_t> groups = {}, const std::function<Real(const Vec3&)>& room = {});

}  // namespace thixo
