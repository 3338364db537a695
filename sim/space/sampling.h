// Particles of a body: hexagonal close packing inside its shape. Dissertation 4.2.
#pragma once

#include <functional>
#include <vector>

#include "pipeline/geometry/packing.h"
#include "pipeline/geometry/shape.h"
#include "pipeline/geometry/volume_sampling.h"
#include "sim/space/periodic.h"
#include "sim/space/smoothing.h"

namespace thixo {

/// The sites of a packing that lie inside `shape` (distance < 0) and where `allowed` holds, ascending in (k, j, i). The
/// packing is centred in the shape's box: in a box the outermost layers stand half a layer inside the faces. Along a
/// periodic axis it goes from face to face, the same for every body, stretched (`packing_stretch`) to continue across
/// them. Throws InputError where the shape is unbounded, or has room for more than 2^31 sites.
std::vector<Vec3> pack_shape(const Shape& shape, Real spacing, const std::function<bool(const Vec3&)>& allowed,
                             const Periodic& periodic = {});

/// Sites of a packing that is fitted to the shape, and the volume that each stands for.
struct FittedPacking {
    std::vector<Vec3> position;  // [m]
    double volume = 0;           // of a site [m^3]
};
/// The packing of pack_shape, stretched along each axis so that whole rows fill the shape's box. It is then scaled by up
/// to four per cent. Its sites then stand for the shape's volume within a thousandth, or as nearly as it goes. A site's
/// volume is the shape's volume over the number of sites, those that are not allowed among them. So a liquid has the
/// mass of its shape. Along periodic axes the packing is as in pack_shape, and no scale is sought.
FittedPacking fit_packing(const Shape& shape, Real spacing, const std::function<bool(const Vec3&)>& allowed,
                          const Periodic& periodic = {});

/// The sites of a solid's packing, in the shape. In a flat box its layers lie across the short side. It is stretched
/// across the layers, and alike along both axes within them. The outermost rows then stand a fifth to a third of a step
/// inside the box. Along the longer axis of the layers they stand as it comes. An element at a surface is strained as a
/// place about a third of a step deeper is. So the strains sample the body evenly. A site's volume is that of its cell's
/// part inside. Where an axis is periodic, the packing is not turned, and fits its period there.
SampledVolume pack_solid(const Shape& shape, Real spacing, const Periodic& periodic = {});

/// The factor by which a packing is stretched along each axis, so that whole rows fill the period; 1 where there is
/// none.
Vec3d packing_stretch(Real spacing, const Periodic& periodic);

}  // namespace thixo
