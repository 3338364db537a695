// What a denoiser is told of a picture: the samples of each pixel in two halves, and features that lead it.
#pragma once

#include <span>

#include "render/denoise/planes.h"
#include "render/passes.h"

namespace thixo::render {

/// Features of a pixel, means of its samples: colour seen, normal of the first surface, way to what is seen, nearness.
/// Normal and way are told to the right and down in the picture.
inline constexpr int kFeatures = 8;

/// The samples of one pixel, summed. Those of even number are half 0, those of odd number half 1.
struct GuidePixel {
    struct Half {
        Vec3d sum{0, 0, 0}, squares{0, 0, 0};  // of the radiance
        int samples = 0;
    };
    std::array<Half, 2> halves;
    std::array<double, kFeatures> features{}, squares{};
    /// Nearness is measured by the distance that the camera is focused on, and zero where nothing is hit.
    ///   nearness = focus / depth   [1]
    void add(const Vec3f& radiance, const FirstHit& first, const Camera& camera);
};

struct Guides {
    /// `light_groups`: how many there are.
    Guides(int width, int height, std::size_t light_groups = 0);
    /// Requires two samples at least. `group_sums`: the radiance of each light group, summed over half 0, then over
    /// half 1.
    void store(int x, int y, const GuidePixel& pixel, std::span<const Vec3d> group_sums = {});

    std::array<Planes, 2> light;                // mean radiance of each half, three planes [W/(m^2 sr)]
    std::array<Planes, 2> variance;             // of these means, three planes
    std::vector<std::array<Planes, 2>> groups;  // as `light`, of each light group
    Planes features, feature_variance;
};

}  // namespace thixo::render
