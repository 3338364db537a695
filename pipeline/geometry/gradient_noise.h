// Gradient noise and its fractal sums, with their derivatives.
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

struct NoiseSample {
    float value = 0;
    Vec3f gradient{0, 0, 0};
};

/// Gradient noise (Perlin 1985 and 2002): zero at the points of the integer lattice, smooth to the second derivative,
/// about -0.9 to 0.9. Value and gradient, which is exact.
NoiseSample gradient_noise(const Vec3f& p);

/// sum over octaves k of 2^-k noise(2^k p): each half as wide and half as high as the one before.
NoiseSample fractal_noise(const Vec3f& p, int octaves);
/// Its value alone.
float fractal_noise_value(const Vec3f& p, int octaves);

}  // namespace thixo
