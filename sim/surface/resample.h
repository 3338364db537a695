// Step 4 of the animated surface: surfels are added where they are sparse and taken away where they crowd.
// Dissertation 6.6.2.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/contract/scene.h"
#include "sim/surface/liquid_shape.h"
#include "sim/surface/surface.h"
#include "sim/surface/surroundings.h"

namespace thixo {

/// What an update knows of each surfel beside its state.
struct SurfelNotes {
    std::vector<std::int32_t> component;
    std::vector<Real> curvature;  // of the liquid's surface [1/m]
    std::vector<Real> radius;     // r_s [m]
    std::vector<WallNote> wall;
    std::vector<ColourNote> colour;
    std::vector<Real> melt;  // of the matter about it; 0: it is a solid's, and resampling leaves it alone [1]
    std::vector<Real> give;  // share of the lift each has, once all have their place
    std::vector<char> lost;  // to be deleted
    SurfelLists lists;       // of the surfels there are, but for those just lost and found
};

/// Radius of a surfel: `full`, less where the surface bends: half of its radius of curvature, but not under 0.6 of
/// `full`. A drop of a single particle has surfels enough to look round.
inline Real fitting_radius(Real curvature, Real full) {
    return curvature * full > Real(0.5) ? std::max(Real(0.5) / curvature, Real(0.6) * full) : full;
}

struct ResampleReport {
    std::size_t inserted = 0, deleted = 0;
};

/// Deletes the surfels marked as lost and thins out crowds, then fills gaps until none is left:
/// - a surfel goes when another one of its side is nearer than 0.55 r_s (of the smaller);
/// - a particle near the surface whose projected place has no surfel within r_s seeds one there;
/// - a circle of radius r_s about a surfel must have no point farther than 0.8 r_s from every other surfel: the
/// farthest such point gets one. So every empty circle in the surface is smaller than a surfel's disc, and discs leave
/// no hole; where the coat of a wall ends there for a dry spot under liquid, the free surface over the spot gets it.
/// New surfels lie on the smooth surface of their neighbours (not to pop), on the iso-surface where they have too few.
/// Between the two distances nothing changes: a surface at rest keeps its surfels. New ids are given in the order of
/// the surfels and particles they come from.
ResampleReport resample(SurfaceState& surface, SurfelNotes& notes, const LiquidShape& shape, const Particles& particles,
                        const scene::Surface& params);

}  // namespace thixo
