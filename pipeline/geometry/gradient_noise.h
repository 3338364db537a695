// Gradient noise and its fractal sums, with their derivatives.
#pragma once

#include "pipeline/base/math.h"

namespace thixo {

struct NoiseSample {
    float value = 0;
    Vec3f gradient{0, 0, 0};
};

/// Gradient noise (Perlin 1985 and 2002). It is zero at the points of the integer lattice, has continuous second
/// derivatives and lies between about -0.9 and 0.9. Gives the value and the exact gradient.
NoiseSample gradient_noise(const Vec3f& p);

/// Fractal noise: the sum over octaves k, each half as wide and half as high as the one before:
///     sum_k 2^-k noise(2^k p)
NoiseSample fractal_noise(const Vec3f& p, int octaves);
/// The value of fractal_noise alone.
float fractal_noise_value(const Vec3f& p, int octaves);

}  // namespace thixo
