// Colours of values. All colours are display colours (sRGB, in [0, 1]).
#pragma once

#include <cstdint>

#include "pipeline/base/math.h"

namespace thixo::preview {

/// Perceptual map from dark violet over blue and green to light yellow. In OKLCh, lightness grows linearly with t, and
/// hue falls linearly. Chroma is as high as sRGB allows, up to 0.15. Source: OKLab (Ottosson 2020). t is clamped to
/// [0, 1]; NaN gives magenta.
Vec3f map_colour(double t);

/// Distinct colour of a small whole number (a body, a material): equal lightness, hues a golden angle apart.
Vec3f category_colour(std::int64_t value);

/// sRGB transfer of a linear Rec.709 colour (IEC 61966-2-1), clamped to [0, 1].
Vec3f encode_srgb(const Vec3d& linear);

/// R, G, B, 255 in ascending bytes.
std::uint32_t pack_colour(const Vec3f& colour);

}  // namespace thixo::preview
