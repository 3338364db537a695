// Light from all sides, given by a picture.
#pragma once

#include <vector>

#include "render/warp.h"

namespace thixo::render {

/// A picture in longitude and latitude: columns go round from +x over -y, rows from +z down. Between texel centres the
/// light is bilinear. Directions are chosen by cells of one texel, evenly in solid angle within a cell (Pharr, Jakob &
/// Humphreys 2023, 12.5). The chance of a cell is proportional to the mean luminance of the bilinear light in it times
/// its solid angle. Where light comes from, there is a chance.
class Environment {
  public:
    /// Radiance [W/(m^2 sr)], row by row from the top. Requires width * height values, all finite, none negative.
    Environment(int width, int height, std::vector<Vec3f> radiance);

    Vec3f radiance(const Vec3f& direction) const;

    struct Sample {
        Vec3f direction{0, 0, 1};
        float pdf = 0;  // 1/sr; 0: everything is black
    };
    Sample sample(const Vec2f& u) const;
    /// The density sample() has for this direction [1/sr].
    float pdf(const Vec3f& direction) const;

    /// Mean over the sphere.
    const Vec3f& mean() const { return mean_; }

  private:
    struct Place {
        float column, row;  // in texels, from the left and top edge
    };
    Place place(const Vec3f& direction) const;
    void make_distribution();
    float cell_share(int column, int row) const;
    const Vec3f& at(int column, int row) const;

    int width_, height_;
    std::vector<Vec3f> radiance_;
    std::vector<float> edge_;        // z of the rows' edges, height + 1
    std::vector<float> row_end_;     // chance of this row and those before it
    std::vector<float> column_end_;  // in each row, chance of this column and those before it
    Vec3f mean_{0, 0, 0};
};

}  // namespace thixo::render
