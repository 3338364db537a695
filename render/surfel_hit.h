// Where a ray meets the blended surface.
#pragma once

#include "render/surfel_gather.h"

namespace thixo::render {

struct SurfelHit {
    float t = kInfinity;
    Vec3f normal{0, 0, 1};  // outward, unit
    float radius = 0;       // of the surfels there, sqrt(|t1||t2|) [m]
    std::uint32_t layer = 0;
    int count = 0;  // surfels that took part, with weights that sum to one; filled where asked for
    Index source[Candidates::kCapacity];
    float weight[Candidates::kCapacity];
};

}  // namespace thixo::render
