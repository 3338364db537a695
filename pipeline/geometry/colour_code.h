// sRGB coding of colours in files (IEC 61966-2-1).
#pragma once

#include <algorithm>
#include <cmath>

#include "pipeline/base/math.h"

namespace thixo {

inline float linear_from_srgb(float c) {
    c = std::clamp(c, 0.f, 1.f);
    return c <= 0.04045f ? c / 12.92f : float(std::pow((double(c) + 0.055) / 1.055, 2.4));
}
inline float srgb_from_linear(float c) {
    c = std::clamp(c, 0.f, 1.f);
    return c <= 0.0031308f ? c * 12.92f : float(1.055 * std::pow(double(c), 1 / 2.4) - 0.055);
}
inline Vec3f linear_from_srgb(const Vec3f& c) {
    return {linear_from_srgb(c.x()), linear_from_srgb(c.y()), linear_from_srgb(c.z())};
}

}  // namespace thixo
