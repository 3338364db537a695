// Directions from uniform numbers.
#pragma once

#include <algorithm>
#include <cmath>

#include "pipeline/base/math.h"

namespace thixo::render {

inline constexpr float kPif = float(kPi);

/// Local direction (z up) to world, about the unit vector n.
inline Vec3f to_world(const Vec3f& local, const Vec3f& n) {
    Vec3f a, b;
    orthonormal_basis(n, a, b);
    return local.x() * a + local.y() * b + local.z() * n;
}

/// Even on the unit disc, squares to rings (Shirley & Chiu 1997).
inline Vec2f sample_disc(const Vec2f& u) {
    const float x = 2 * u.x() - 1, y = 2 * u.y() - 1;
    if (x == 0 && y == 0) return {0, 0};
    const bool wide = std::abs(x) > std::abs(y);
    const float r = wide ? x : y;
    const float phi = wide ? kPif / 4 * (y / x) : kPif / 2 - kPif / 4 * (x / y);
    return {r * std::cos(phi), r * std::sin(phi)};
}

/// About +z with density cos/pi.
inline Vec3f sample_cosine(const Vec2f& u) {
    const Vec2f d = sample_disc(u);
    return {d.x(), d.y(), std::sqrt(std::max(1e-12f, 1 - d.squaredNorm()))};
}

/// About +z, even in the cone of 1 - cos(half angle) = height; density 1/(2 pi height).
inline Vec3f sample_cone(const Vec2f& u, float height) {
    const Vec2f d = sample_disc(u);
    const float r2 = d.squaredNorm(), h = r2 * height;  // 1 - z
    const float scale = std::sqrt(std::max(0.0f, height * (2 - h)));
    return {d.x() * scale, d.y() * scale, 1 - h};
}

inline float luminance(const Vec3f& c) { return 0.2126f * c.x() + 0.7152f * c.y() + 0.0722f * c.z(); }

}  // namespace thixo::render
