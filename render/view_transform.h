// Scene-linear light to what a screen shows.
#pragma once

#include "pipeline/contract/image.h"
#include "pipeline/contract/scene.h"

namespace thixo::render {

/// Scales x by 2^exposure, then applies the curve, then the sRGB transfer function. The result is in [0, 1]. The curves
/// are monotone in x:
///
///     srgb     min(x, 1)
///     filmic   x                                         where x <= a
///              a + (1 - a)(1 - exp(-(x - a)/(1 - a)))    where x > a,   a = 0.5   [1]
///
/// With filmic, middle tones stay as they are, and highlights run into white without an edge.
float view_transform(float x, scene::ViewTransform view, double exposure);

/// 8-bit picture of the R G B (A) channels; alpha is kept where it is below one anywhere.
Image8 to_display(const Image& image, scene::ViewTransform view, double exposure);

}  // namespace thixo::render
