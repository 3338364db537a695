// A shape sampled on a sparse grid, for fast queries of costly shapes (meshes, deep trees).
#pragma once

#include <optional>

#include "pipeline/geometry/shape.h"

namespace thixo {

/// Samples a shape: trilinear in cells of edge `cell` [m] wherever the surface is nearer than `band` [m], trilinear in
/// blocks of 8 cells farther off, with the sign right wherever the shape is thicker than a cell. Outside the sampled
/// box (the shape's bounds grown by band, or `box`): distance of the nearest point in the box plus the distance to it,
/// an upper bound. Throws InputError where the shape is unbounded and no box is given, or the grid would have more than
/// 2^28 samples.
Shape sampled(const Shape& shape, double cell, double band, std::optional<Box3> box = std::nullopt);

}  // namespace thixo
