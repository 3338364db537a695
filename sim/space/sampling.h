// Particles where a body is: hexagonal close packing inside a shape. Dissertation 4.2.
#pragma once

#include <functional>
#include <vector>

#include "pipeline/geometry/packing.h"
#include "pipeline/geometry/shape.h"
#include "sim/space/periodic.h"
#include "sim/space/smoothing.h"

namespace thixo {

/// The sites of a packing that lie inside `shape` (distance < 0) and where `allowed` holds, in ascending order of (k,
/// j, i). The packing is centred in the shape's box, so that in a box the outermost layers stand half a layer inside
/// the faces. Along a periodic axis it is laid from face to face, the same for every body, and stretched
/// (`packing_stretch`) so that it continues across them. Throws InputError where the shape is unbounded, or has room
/// for more than 2^31 sites.
std::vector<Vec3> pack_shape(const Shape& shape, Real spacing, const std::function<bool(const Vec3&)>& allowed,
                             const Periodic& periodic = {});

/// What a packing is stretched by along each axis so that whole rows of it fill the period; 1 where there is none.
Vec3d packing_stretch(Real spacing, const Periodic& periodic);

}  // namespace thixo
