// How densely surfels cover a solid of the scene at the start.
#pragma once

#include "pipeline/contract/scene.h"
#include "pipeline/geometry/surface_sampling.h"

namespace thixo {

/// Body::surfels of them, or as dense as surface.radius asks for.
inline SurfaceSampling skin_sampling(const scene::Scene& scene, const scene::Body& body) {
    if (body.surfels > 0) return {.count = static_cast<std::size_t>(body.surfels), .seed = scene.solver.seed};
    return {.spacing = scene.surface.radius * scene.solver.spacing, .seed = scene.solver.seed};
}

}  // namespace thixo
