// A field of squares, filtered over what a pixel sees.
#pragma once

#include "render/ray.h"

namespace thixo::render {

/// The share of the first colour about a place, in a field of cubes of two colours by x and y [1]. Each coordinate is
/// averaged over the width that a pixel sees there, less a quarter of a cube. What is sharper the samples of a pixel
/// average themselves.
///     share = (1 + s(x) s(y))/2,   s the mean of a square wave of +1 and -1
float checker_share(const Vec3f& place, const Vec3f& width, float cube);

/// How wide what a pixel sees is along x, y, z [m]. in_rest: in m0, as checkers and images may lie, else in the world.
Vec3f seen_width(const Hit& hit, bool in_rest);

}  // namespace thixo::render
