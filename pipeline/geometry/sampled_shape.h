// A shape sampled on a sparse grid, for fast queries of costly shapes (meshes, deep trees).
#pragma once

#include <optional>

#include "pipeline/geometry/shape.h"

namespace thixo {

/// Samples the distance of a shape. It is trilinear in cells of the edge `cell` [m] where the surface is nearer than
/// `band` [m], and in blocks of 8 cells elsewhere. The sign is right wherever the shape is thicker than a cell. The
/// sampled box is `box`, or the shape's bounds extended by band. Outside it the result is an upper bound: the distance
/// of the box's nearest point plus the distance to that point. Throws InputError where the shape is unbounded and no
/// box is given, or the grid would have more than 2^28 samples.
Shape sampled(const Shape& shape, double cell, double band, std::optional<Box3> box = std::nullopt);

}  // namespace thixo
