#include "render/denoise/guides.h"

#include "pipeline/base/error.h"

namespace thixo::render {

namespace {

/// Of the mean of n numbers, from their sum and that of their squares.
double variance_of_mean(double sum, double squares, int n) {
    return std::max(0.0, squares / n - square(sum / n)) / (n - 1);
}

}  // namespace

void GuidePixel::add(const Vec3f& radiance, const FirstHit& first, const Camera& camera) {
    Half& half = halves[std::size_t(halves[0].samples > halves[1].samples)];
    const Vec3d c = radiance.cast<double>();
    half.sum += c;
    half.squares += c.cwiseProduct(c);
    ++half.samples;
    const Vec3f seen = first.seen.cwiseMin(1.0f);
    const float nearness = first.found && first.depth > 0 ? camera.focus / first.depth : 0.0f;
    const std::array<float, kFeatures> now{seen.x(),
                                           seen.y(),
                                           seen.z(),
                                           first.normal.dot(camera.right),
                                           first.normal.dot(camera.down),
                                           first.way.dot(camera.right),
                                           first.way.dot(camera.down),
                                           nearness};
    for (std::size_t k = 0; k < now.size(); ++k) {
        features[k] += double(now[k]);
        squares[k] += square(double(now[k]));
    }
}

Guides::Guides(int width, int height, std::size_t light_groups)
    : light{Planes(3, width, height), Planes(3, width, height)},
      variance{Planes(3, width, height), Planes(3, width, height)},
      groups(light_groups, light),
      features(kFeatures, width, height),
      feature_variance(kFeatures, width, height) {}

void Guides::store(int x, int y, const GuidePixel& pixel, std::span<const Vec3d> group_sums) {
    const GuidePixel::Half &a = pixel.halves[0], &b = pixel.halves[1];
    const int n = a.samples + b.samples;
    THIXO_ASSERT(b.samples > 0, "{} samples have no two halves", n);
    for (int c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < 2; ++k) {
            const GuidePixel::Half& half = pixel.halves[k];
            *light[k].at(c, x, y) = float(half.sum[c] / half.samples);
            // A single sample has no spread: then that of both halves counts.
            *variance[k].at(c, x, y) =
                float(half.samples > 1 ? variance_of_mean(half.sum[c], half.squares[c], half.samples)
                                       : n * variance_of_mean(a.sum[c] + b.sum[c], a.squares[c] + b.squares[c], n));
        }
    for (std::size_t i = 0; i < group_sums.size(); ++i) {
        const std::size_t half = i / groups.size();
        for (int c = 0; c < 3; ++c)
            *groups[i % groups.size()][half].at(c, x, y) = float(group_sums[i][c] / pixel.halves[half].samples);
    }
    for (int k = 0; k < kFeatures; ++k) {
        const auto i = std::size_t(k);
        *features.at(k, x, y) = float(pixel.features[i] / n);
        *feature_variance.at(k, x, y) = float(variance_of_mean(pixel.features[i], pixel.squares[i], n));
    }
}

}  // namespace thixo::render
