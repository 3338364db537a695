#include "render/preview/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/geometry/colour_code.h"

namespace thixo::preview {

namespace {

Vec3d oklch_to_linear(double lightness, double chroma, double hue_degrees) {
    const double h = hue_degrees * kPi / 180;
    const double a = chroma * std::cos(h), b = chroma * std::sin(h);
    const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
    const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
    const double s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
            -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
            -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

// The colour of this lightness and hue whose chroma is the largest one in the sRGB cube, at most `chroma`.
Vec3d in_gamut(double lightness, double chroma, double hue_degrees) {
    const auto fits = [](const Vec3d& c) { return c.minCoeff() >= 0 && c.maxCoeff() <= 1; };
    Vec3d colour = oklch_to_linear(lightness, chroma, hue_degrees);
    if (fits(colour)) return colour;
    double low = 0, high = chroma;
    for (int i = 0; i < 24; ++i) {
        const double middle = 0.5 * (low + high);
        (fits(oklch_to_linear(lightness, middle, hue_degrees)) ? low : high) = middle;
    }
    return oklch_to_linear(lightness, low, hue_degrees);
}

std::array<Vec3f, 256> make_map() {
    std::array<Vec3f, 256> map;
    for (int i = 0; i < 256; ++i) {
        const double t = i / 255.0;
        map[static_cast<std::size_t>(i)] = encode_srgb(in_gamut(0.32 + 0.60 * t, 0.15, 300 - 195 * t));
    }
    return map;
}

}  // namespace

Vec3f map_colour(double t) {
    static const std::array<Vec3f, 256> map = make_map();
    if (std::isnan(t)) return {1, 0, 1};
    const double x = 255 * std::clamp(t, 0.0, 1.0);
    const std::size_t i = std::min<std::size_t>(254, static_cast<std::size_t>(x));
    const float f = static_cast<float>(x - static_cast<double>(i));
    return (1 - f) * map[i] + f * map[i + 1];
}

Vec3f category_colour(std::int64_t value) {
    const double hue = std::fmod(250.0 + 137.50776 * static_cast<double>(value % 4096), 360.0);
    return encode_srgb(in_gamut(0.70, 0.14, hue));
}

Vec3f encode_srgb(const Vec3d& linear) {
    const Vec3f c = linear.cast<float>();
    return {srgb_from_linear(c.x()), srgb_from_linear(c.y()), srgb_from_linear(c.z())};
}

std::uint32_t pack_colour(const Vec3f& colour) {
    const auto byte = [](float c) { return static_cast<std::uint32_t>(255 * clamp01(c) + 0.5f); };
    return byte(colour[0]) | byte(colour[1]) << 8 | byte(colour[2]) << 16 | 0xff000000u;
}

}  // namespace thixo::preview
