#include "pipeline/geometry/gradient_noise.h"

#include <cmath>

#include "pipeline/base/random.h"

namespace thixo {
namespace {

/// One of the twelve edges of a cube, by a hash of the lattice point: evenly spread, and sums stay small numbers.
Vec3f lattice_gradient(std::int32_t x, std::int32_t y, std::int32_t z) {
    constexpr float edges[16][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                    {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
                                    {1, 1, 0},  {-1, 1, 0},  {0, -1, 1}, {0, -1, -1}};
    const std::uint64_t key =
        std::uint64_t(std::uint32_t(x)) << 42 ^ std::uint64_t(std::uint32_t(y)) << 21 ^ std::uint64_t(std::uint32_t(z));
    const float* g = edges[mix64(key) & 15];
    return {g[0], g[1], g[2]};
}

float fade(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }
float fade_slope(float t) { return 30 * t * t * (t * (t - 2) + 1); }

/// With the gradient or, at half the cost, without.
template <bool kSlope>
NoiseSample noise_at(const Vec3f& p) {
    const Vec3f base(std::floor(p.x()), std::floor(p.y()), std::floor(p.z())), f = p - base;
    const auto x = std::int32_t(base.x()), y = std::int32_t(base.y()), z = std::int32_t(base.z());
    const float w[3][2] = {
        {1 - fade(f.x()), fade(f.x())}, {1 - fade(f.y()), fade(f.y())}, {1 - fade(f.z()), fade(f.z())}};
    const Vec3f slope(fade_slope(f.x()), fade_slope(f.y()), fade_slope(f.z()));
    NoiseSample s;
    for (int corner = 0; corner < 8; ++corner) {
        const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
        const Vec3f g = lattice_gradient(x + i, y + j, z + k);
        const float v = g.dot(f - Vec3f(float(i), float(j), float(k)));
        const float wi = w[0][i], wj = w[1][j], wk = w[2][k];
        s.value += wi * wj * wk * v;
        if constexpr (!kSlope) continue;
        s.gradient += wi * wj * wk * g;
        s.gradient += v * Vec3f((i ? 1 : -1) * slope.x() * wj * wk, (j ? 1 : -1) * slope.y() * wi * wk,
                                (k ? 1 : -1) * slope.z() * wi * wj);
    }
    return s;
}

/// Shifted from octave to octave, or the zeros of all would fall together at the lattice of the first.
Vec3f place_in_octave(const Vec3f& p, float frequency, int k) {
    return frequency * p + Vec3f::Constant(17.31f * float(k));
}

}  // namespace

NoiseSample gradient_noise(const Vec3f& p) { return noise_at<true>(p); }

NoiseSample fractal_noise(const Vec3f& p, int octaves) {
    NoiseSample sum;
    float frequency = 1;
    for (int k = 0; k < octaves; ++k, frequency *= 2) {
        const NoiseSample s = noise_at<true>(place_in_octave(p, frequency, k));
        sum.value += s.value / frequency;
        sum.gradient += s.gradient;  // 1/frequency times the inner derivative
    }
    return sum;
}

float fractal_noise_value(const Vec3f& p, int octaves) {
    float sum = 0, frequency = 1;
    for (int k = 0; k < octaves; ++k, frequency *= 2)
        sum += noise_at<false>(place_in_octave(p, frequency, k)).value / frequency;
    return sum;
}

}  // namespace thixo
