// Step 4 of the animated surface: surfels are added where they are sparse and removed where they crowd. Dissertation
// 6.6.2.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/contract/scene.h"
#include "sim/surface/liquid_shape.h"
#include "sim/surface/surface.h"
#include "sim/surface/surroundings.h"

namespace thixo {

/// Notes of an update about each surfel, beside its state.
struct SurfelNotes {
    std::vector<std::int32_t> component;
    std::vector<Real> curvature;  // of the liquid's surface [1/m]
    std::vector<Real> radius;     // r_s [m]
    std::vector<WallNote> wall;
    std::vector<ColourNote> colour;
    std::vector<Real> melt;  // of the matter about it; 0: it belongs to a solid, and resampling leaves it alone [1]
    std::vector<Real> lift_share;  // share of the lift of each, once all have their places
    std::vector<char> lost;        // to be deleted
    SurfelLists lists;             // of the present surfels, without those just lost and found
};

/// Radius of a surfel: `full`, or half of the surface's radius of curvature where that is smaller, but at least 0.6 of
/// `full`. A drop of a single particle then has enough surfels to look round.
inline Real fitting_radius(Real curvature, Real full) {
    return curvature * full > Real(0.5) ? std::max(Real(0.5) / curvature, Real(0.6) * full) : full;
}

struct ResampleReport {
    std::size_t inserted = 0, deleted = 0;
};

/// Deletes the surfels marked as lost, thins out crowds, and fills gaps until none is left:
/// - A surfel is deleted when another one of its side is nearer than 0.55 r_s (of the smaller).
/// - A particle near the surface whose projected place has no surfel within r_s seeds one there.
/// - On a circle of radius r_s about a surfel no point may be farther than 0.8 r_s from every other surfel. The
///   farthest such point gets one. Every empty circle in the surface is then smaller than a surfel's disc, and discs
///   leave no hole. Where the coat of a wall ends at a dry spot under liquid, the free surface over the spot gets the
///   surfel.
///
/// New surfels lie on the smooth surface of their neighbours, so that they do not pop, or on the iso-surface where they
/// have too few. Between the two distances nothing changes: a surface at rest keeps its surfels. New ids follow the
/// order of the surfels and particles that they come from.
ResampleReport resample(SurfaceState& surface, SurfelNotes& notes, const LiquidShape& shape,
                        const ParticleRows& particles, const scene::Surface& params);

}  // namespace thixo
