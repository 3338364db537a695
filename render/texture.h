// Pictures on surfaces.
#pragma once

#include <vector>

#include "pipeline/base/math.h"

namespace thixo::render {

/// A picture repeated without end over the plane of (u, v), one picture a unit square, v upwards from its lower edge.
/// Each smaller level has half the texels of the one before, each the mean of what it covers.
class Texture {
  public:
    /// Linear colours, row by row from the top. Requires width * height values.
    Texture(int width, int height, std::vector<Vec3f> colours);

    /// Filtered over about `footprint`, as a part of the picture's width and height. It mixes the two levels whose
    /// texels are next to that size, bilinear in each. 0: bilinear in the picture itself; exact at texel centres.
    Vec3f colour(const Vec2f& uv, const Vec2f& footprint) const;

    int width() const { return levels_.front().width; }
    int height() const { return levels_.front().height; }

  private:
    struct Level {
        int width = 0, height = 0;
        std::vector<Vec3f> colours;
        Vec3f bilinear(const Vec2f& uv) const;
    };
    static Level smaller(const Level& level);
    std::vector<Level> levels_;
};

}  // namespace thixo::render
