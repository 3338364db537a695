#include "pipeline/geometry/gradient_noise.h"

#include <cmath>
#include <vector>

#include "pipeline/base/random.h"

namespace thixo {
namespace {

/// The direction to one of the twelve edges of a cube, by a hash of the lattice point. The directions are evenly
/// spread.
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

/// The gradients at the eight corners of a lattice cube. They are kept, because the next place is mostly near the last.
struct LatticeCube {
    std::int32_t x = 0, y = 0, z = 0;
    bool known = false;
    float gx[8], gy[8], gz[8];

    void move_to(std::int32_t to_x, std::int32_t to_y, std::int32_t to_z) {
        if (known && x == to_x && y == to_y && z == to_z) return;
        x = to_x, y = to_y, z = to_z, known = true;
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3f g = lattice_gradient(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2));
            gx[corner] = g.x(), gy[corner] = g.y(), gz[corner] = g.z();
        }
    }
};

float sum_of(const float (&part)[8]) {
    return ((part[0] + part[4]) + (part[2] + part[6])) + ((part[1] + part[5]) + (part[3] + part[7]));
}

/// The noise with its gradient or, at half the cost, without.
template <bool kSlope>
NoiseSample noise_at(const Vec3f& p, LatticeCube& cube) {
    const Vec3f base(std::floor(p.x()), std::floor(p.y()), std::floor(p.z())), f = p - base;
    cube.move_to(std::int32_t(base.x()), std::int32_t(base.y()), std::int32_t(base.z()));
    const float x1 = fade(f.x()), y1 = fade(f.y()), z1 = fade(f.z());
    const float slope_x = fade_slope(f.x()), slope_y = fade_slope(f.y()), slope_z = fade_slope(f.z());
    float value[8], along_x[8], along_y[8], along_z[8];
    for (int c = 0; c < 8; ++c) {
        const float i = float(c & 1), j = float(c >> 1 & 1), k = float(c >> 2);
        const float wi = 1 - i + (2 * i - 1) * x1, wj = 1 - j + (2 * j - 1) * y1, wk = 1 - k + (2 * k - 1) * z1;
        const float v = cube.gx[c] * (f.x() - i) + cube.gy[c] * (f.y() - j) + cube.gz[c] * (f.z() - k);
        value[c] = wi * wj * wk * v;
        if constexpr (!kSlope) continue;
        along_x[c] = wj * wk * (wi * cube.gx[c] + (2 * i - 1) * slope_x * v);
        along_y[c] = wi * wk * (wj * cube.gy[c] + (2 * j - 1) * slope_y * v);
        along_z[c] = wi * wj * (wk * cube.gz[c] + (2 * k - 1) * slope_z * v);
    }
    if constexpr (!kSlope) return {sum_of(value), Vec3f::Zero()};
    return {sum_of(value), Vec3f(sum_of(along_x), sum_of(along_y), sum_of(along_z))};
}

/// Each octave is shifted. Otherwise the zeros of all octaves would coincide at the lattice of the first.
Vec3f place_in_octave(const Vec3f& p, float frequency, int k) {
    return frequency * p + Vec3f::Constant(17.31f * float(k));
}

/// The cubes that this thread used last: one for each octave.
LatticeCube& last_cube(int octave) {
    thread_local std::vector<LatticeCube> cubes;
    if (cubes.size() <= std::size_t(octave)) cubes.resize(std::size_t(octave) + 1);
    return cubes[std::size_t(octave)];
}

}  // namespace

NoiseSample gradient_noise(const Vec3f& p) { return noise_at<true>(p, last_cube(0)); }

NoiseSample fractal_noise(const Vec3f& p, int octaves) {
    NoiseSample sum;
    float frequency = 1;
    for (int k = 0; k < octaves; ++k, frequency *= 2) {
        const NoiseSample s = noise_at<true>(place_in_octave(p, frequency, k), last_cube(k));
        sum.value += s.value / frequency;
        sum.gradient += s.gradient;  // 1/frequency times the inner derivative
    }
    return sum;
}

float fractal_noise_value(const Vec3f& p, int octaves) {
    float sum = 0, frequency = 1;
    for (int k = 0; k < octaves; ++k, frequency *= 2)
        sum += noise_at<false>(place_in_octave(p, frequency, k), last_cube(k)).value / frequency;
    return sum;
}

}  // namespace thixo
