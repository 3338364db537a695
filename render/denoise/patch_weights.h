// How alike two pixels of a noisy picture are, by the patches around them.
#pragma once

#include "render/denoise/planes.h"

namespace thixo::render {

inline constexpr int kPatch = 3;  // pixels to each side

struct PatchMetric {
    const Planes &values, &variances;
    int first, count;  // planes that take part
    float width;       // difference that still counts as alike, in standard deviations
};

/// The distance of every pixel p of a tile-sized rectangle from (x, y) to the pixel q = p + (dx, dy).
///
///   d = mean over patch and planes of ((u_p - u_q)^2 - (v_p + min(v_p, v_q))) / (e + width^2 (v_p + v_q))   [1]
/// with values u and variances v.
///
/// It is about zero or less where noise alone parts them. Rousselle et al. 2012,
/// "Adaptive rendering with non-local means filtering", equation 5.
void patch_distances(const PatchMetric& metric, int x, int y, int dx, int dy, float* distances);

/// Weight of a distance: (1 - d/4)^4, close to exp(-d), and zero from d = 4 on.
inline FloatLanes kernel(FloatLanes d) {
    const FloatLanes a = larger(float_lanes(0), 1.0f - 0.25f * larger(float_lanes(0), d));
    return (a * a) * (a * a);
}

/// The planes averaged over windows of `radius` pixels to each side, each pixel by its weight.
Planes nonlocal_mean(const Planes& planes, const PatchMetric& metric, int radius);

}  // namespace thixo::render
