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

/// The shading normal on a surface that is raised along its normal by
///
///     h = amplitude noise(m0/scale)   [m]
///
/// With the tangents a, b that the derivatives of m0 at the hit belong to it is
///
///     n' = unit(n - dh/da a - dh/db b),   dh/da = amplitude/scale grad noise . dm0/da   [1]
///
/// Where n' would lean to the other side of the surface, the hit's own normal is returned.
Vec3f bumped_normal(const Bump& bump, const Hit& hit);

}  // namespace thixo::render
