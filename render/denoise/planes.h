// Numbers of a picture, a plane for each kind, laid out so that eight neighbours in a row are one load.
#pragma once

#include <vector>

#include "pipeline/base/lanes.h"
#include "pipeline/base/parallel.h"

namespace thixo::render {

/// Pixels that are worked on together.
inline constexpr int kTileWidth = 32, kTileHeight = 16;

/// Every plane has whole tiles and a border around them, so that windows and patches need no tests for the edge.
class Planes {
  public:
    static constexpr int kBorder = 24;  // pixels

    Planes(int planes, int width, int height)
        : width_(width),
          height_(height),
          stride_(whole(width, kTileWidth) + 2 * kBorder),
          size_(std::size_t(stride_) * std::size_t(whole(height, kTileHeight) + 2 * kBorder)),
          values_(std::size_t(planes) * size_) {}

    int width() const { return width_; }
    int height() const { return height_; }
    int count() const { return int(values_.size() / size_); }

    /// x and y may lie in the border.
    float* at(int plane, int x, int y) { return values_.data() + index(plane, x, y); }
    const float* at(int plane, int x, int y) const { return values_.data() + index(plane, x, y); }

    /// Gives what lies outside of the picture the values of its outermost pixels.
    void extend() {
        const int rows = int(size_) / stride_ - kBorder, columns = stride_ - kBorder;
        for (int k = 0; k < count(); ++k)
            for (int y = -kBorder; y < rows; ++y) {
                const float* const from = at(k, 0, std::clamp(y, 0, height_ - 1));
                float* const to = at(k, 0, y);
                for (int x = -kBorder; x < columns; ++x)
                    if (x < 0 || x >= width_ || y < 0 || y >= height_) to[x] = from[std::clamp(x, 0, width_ - 1)];
            }
    }

  private:
    static int whole(int pixels, int tile) { return (pixels + tile - 1) / tile * tile; }
    std::size_t index(int plane, int x, int y) const {
        return std::size_t(plane) * size_ + std::size_t(y + kBorder) * std::size_t(stride_) + std::size_t(x + kBorder);
    }

    int width_, height_, stride_;
    std::size_t size_;  // of a plane
    std::vector<float> values_;
};

/// f(x, y) for the top left pixel of every tile, in parallel.
template <class F>
void for_each_tile(int width, int height, F&& f) {
    const int columns = (width + kTileWidth - 1) / kTileWidth, rows = (height + kTileHeight - 1) / kTileHeight;
    parallel_for(
        std::size_t(columns) * std::size_t(rows),
        [&](std::size_t tile) { f(int(tile) % columns * kTileWidth, int(tile) / columns * kTileHeight); }, 1);
}

/// Eight neighbours in a row.
inline FloatLanes lanes_at(const float* from) { return _mm256_loadu_ps(from); }
inline void put_lanes(const FloatLanes& a, float* to) { _mm256_storeu_ps(to, a); }
inline FloatLanes smaller(FloatLanes a, FloatLanes b) { return _mm256_min_ps(a, b); }
inline FloatLanes larger(FloatLanes a, FloatLanes b) { return _mm256_max_ps(a, b); }

}  // namespace thixo::render
