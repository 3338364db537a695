// Fractal gradient noise in material coordinates, and the bumps made of it (dissertation 5.6.3).
#pragma once

#include "render/ray.h"

namespace thixo::render {

/// Gradient noise (Perlin 1985 and 2002): zero at the points of the integer lattice, smooth to the second derivative,
/// about -0.9 to 0.9. Value and gradient, which is exact.
struct NoiseSample {
    float value = 0;
    Vec3f gradient{0, 0, 0};
};
NoiseSample gradient_noise(const Vec3f& p);

/// sum over octaves k of 2^-k noise(2^k p): each half as wide and half as high as the one before.
NoiseSample fractal_noise(const Vec3f& p, int octaves);

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
