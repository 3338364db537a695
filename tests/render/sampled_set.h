// Bodies as the simulation samples them, for rays.
#pragma once

#include "pipeline/geometry/surface_sampling.h"
#include "render/ray_scene.h"

namespace thixo::render {

/// One object (0), a layer for every sheet.
inline SurfelSet sampled_set(const Shape& shape, const SurfaceSampling& sampling) {
    const SampledSurface sampled = sample_surface(shape, sampling);
    SurfelSet set;
    set.cloud = sampled.surfels;
    set.layer.assign(sampled.sheet.begin(), sampled.sheet.end());
    set.object.assign(std::size_t(sampled.sheets), 0);
    if (sampled.trim) set.trim = {trim_node(*sampled.trim)};
    return set;
}

}  // namespace thixo::render
