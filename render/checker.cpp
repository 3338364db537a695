#include "render/checker.h"

#include <algorithm>
#include <cmath>

#include "render/warp.h"

namespace thixo::render {
namespace {

/// The integral of a square wave that is +1 on [0, 1), -1 on [1, 2).
float integral(float x) {
    const float in = x - 2 * std::floor(0.5f * x);
    return in < 1 ? in : 2 - in;
}

/// The mean of the wave over [x - width/2, x + width/2], in cubes.
float mean_of_wave(float x, float width) {
    if (width <= 1e-3f) return (std::int64_t(std::floor(x)) & 1) == 0 ? 1.0f : -1.0f;
    const float from = x - 0.5f * width - 2 * std::floor(0.5f * (x - 0.5f * width));  // small: no digits are lost
    return std::clamp((integral(from + width) - integral(from)) / width, -1.0f, 1.0f);
}

}  // namespace

float checker_share(const Vec3f& place, const Vec3f& width, float cube) {
    constexpr float kSharp = 0.25f;  // cubes
    float product = 1;
    for (int k = 0; k < 2; ++k) product *= mean_of_wave(place[k] / cube, std::max(0.0f, width[k] / cube - kSharp));
    return 0.5f * (1 + product);
}

Vec3f seen_width(const Hit& hit, bool in_rest) {
    Vec3f first = hit.attributes.rest_a, second = hit.attributes.rest_b;
    if (!in_rest) orthonormal_basis(hit.geometric, first, second);
    const Vec3f& slant = in_rest ? hit.rest_slant : hit.slant;
    const Vec3f across2 = square(hit.footprint) * (first.cwiseAbs2() + second.cwiseAbs2());
    return (across2 + slant.cwiseAbs2()).cwiseSqrt();
}

}  // namespace thixo::render
