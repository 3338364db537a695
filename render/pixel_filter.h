// Where in and around a pixel its samples lie.
#pragma once

#include <array>

#include "pipeline/base/math.h"

namespace thixo::render {

/// Blackman-Harris window of radius 1.5 pixels. Samples are placed by the inverse of its integral (filter importance
/// sampling, Ernst et al. 2006). Every sample then counts the same, and a pixel depends on its own samples alone.
class PixelFilter {
  public:
    PixelFilter();
    /// Offset from the pixel's centre [pixels].
    Vec2f offset(const Vec2f& u) const { return {at(u.x()), at(u.y())}; }
    static constexpr float kRadius = 1.5f;

  private:
    static constexpr int kSteps = 256;
    float at(float u) const {
        const float x = u * kSteps;
        const int i = std::min(int(x), kSteps - 1);
        return inverse_[i] + (x - float(i)) * (inverse_[i + 1] - inverse_[i]);
    }
    std::array<float, kSteps + 1> inverse_;
};

}  // namespace thixo::render
