// The common case of a blended hit: one smooth patch that faces the ray.
#pragma once

#include "render/surfel_hit.h"
#include "render/trim.h"

namespace thixo::render {

/// The crossing of the candidates where they are one surface without doubt. They are all of one layer. Their normals
/// lie within 35 degrees of each other, and all face the ray by more than 6 degrees. The function f then falls all
/// along the ray, so a root is the first crossing (surfel_blend.h). Newton's steps find it from where the ray meets the
/// discs. It is the same surface as that of first_crossing: weights and fit are the same, and the root is as exact.
/// False: not this case, or no root found; `hit` is then unchanged.
bool smooth_crossing(const Gathering& from, const Trims& trims, const Candidates& candidates, float end,
                     bool want_sources, SurfelHit& hit);

}  // namespace thixo::render
