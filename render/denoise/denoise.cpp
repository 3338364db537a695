#include "render/denoise/denoise.h"

#include "render/denoise/patch_weights.h"
#include "render/denoise/regression.h"

namespace thixo::render {
namespace {

constexpr int kFeatureWindow = 3;
constexpr float kFeatureSpread = 1;  // standard deviations
static_assert(kDenoiseReach >= 2 * kWindow + kPatch + kFeatureWindow + kPatch);

/// Means over the pixel and its eight neighbours: a pixel's own samples tell little of their spread.
Planes smoothed(const Planes& planes) {
    Planes out(planes.count(), planes.width(), planes.height());
    for_each_tile(planes.width(), planes.height(), [&](int x0, int y0) {
        for (int k = 0; k < planes.count(); ++k)
            for (int y = y0; y < y0 + kTileHeight; ++y)
                for (int x = x0; x < x0 + kTileWidth; x += kFloatLanes) {
                    FloatLanes sum{};
                    for (int dy = -1; dy <= 1; ++dy)
                        for (int dx = -1; dx <= 1; ++dx) sum += lanes_at(planes.at(k, x + dx, y + dy));
                    put_lanes(sum * (1.0f / 9), out.at(k, x, y));
                }
    });
    out.extend();
    return out;
}

/// Each group of features in turn: the colour, the normal, the way, the nearness.
Planes filtered_features(const Guides& guides) {
    Planes out(kFeatures, guides.features.width(), guides.features.height());
    for (const auto& [first, count] : {std::pair(0, 3), std::pair(3, 2), std::pair(5, 2), std::pair(7, 1)}) {
        const Planes group = nonlocal_mean(
            guides.features, {guides.features, guides.feature_variance, first, count, kFeatureSpread}, kFeatureWindow);
        for (int k = 0; k < count; ++k)
            for (int y = 0; y < out.height(); ++y) std::copy_n(group.at(k, 0, y), out.width(), out.at(first + k, 0, y));
    }
    out.extend();
    return out;
}

Planes mean(const Planes& a, const Planes& b) {
    Planes out = a;
    for (int k = 0; k < out.count(); ++k)
        for (int y = 0; y < out.height(); ++y)
            for (int x = 0; x < out.width(); ++x) *out.at(k, x, y) = 0.5f * (*a.at(k, x, y) + *b.at(k, x, y));
    return out;
}

}  // namespace

Denoised denoise(Guides guides) {
    for (std::size_t half = 0; half < 2; ++half) {
        guides.light[half].extend();
        for (std::array<Planes, 2>& group : guides.groups) group[half].extend();
        guides.variance[half].extend();
        guides.variance[half] = smoothed(guides.variance[half]);
    }
    guides.features.extend();
    guides.feature_variance.extend();
    guides.features = filtered_features(guides);
    const std::vector<Planes> a = regress(guides, 0), b = regress(guides, 1);
    Denoised out{mean(a[0], b[0]), {}};
    for (int c = 0; c < 3; ++c)
        for (int y = 0; y < out.light.height(); ++y)
            for (int x = 0; x < out.light.width(); ++x) *out.light.at(c, x, y) = std::max(0.0f, *out.light.at(c, x, y));
    for (std::size_t k = 1; k < a.size(); ++k) out.groups.push_back(mean(a[k], b[k]));
    return out;
}

}  // namespace thixo::render
