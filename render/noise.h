// Bumps made of fractal gradient noise in material coordinates (dissertation 5.6.3).
#pragma once

#include "pipeline/geometry/gradient_noise.h"
#include "render/ray.h"

namespace thixo::render {

struct Bump {
    float amplitude = 0;  // m; 0: none
    float scale = 0.01f;  // m, width of the largest bumps
    int octaves = 4;
};

/// The shading normal on a surface raised by amplitude noise(m0 / scale) along its normal:
///   n' = unit(n - dh/da a - dh/db b),   dh/da = amplitude/scale grad noise . dm0/da
/// where a, b are the tangents the hit's dm0 belong to. Kept on the side of the surface's own normal.
Vec3f bumped_normal(const Bump& bump, const Hit& hit);

}  // namespace thixo::render
