// The passes of a picture, in one table. An entry says what a pass is called, how it is stored and how it is gathered
// from the samples of a pixel. Another pass is another entry, and says how many there are.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "render/path.h"

namespace thixo::render {

/// Depth where nothing is hit.
inline constexpr float kFar = 1e10f;

enum class Gathered {
    mean,     // of all samples; those that hit nothing count as zero
    nearest,  // of the hit that is nearest
    pixel     // from the finished pixel
};

struct Pixel;

struct Pass {
    std::string_view layer;    // empty: the channels stand alone
    std::string_view letters;  // a channel each; empty: one channel of the layer's name
    bool half;                 // half or float in the file
    Gathered gathered;
    Vec3f (*of_hit)(const FirstHit&) = nullptr;  // mean, nearest
    Vec3d (*of_pixel)(const Pixel&) = nullptr;   // pixel
    double nothing = 0;                          // nearest: where nothing is hit

    int channels() const { return letters.empty() ? 1 : int(letters.size()); }
    /// Of channel k, as EXR names it: "R", "N.X", "samples".
    std::string channel(int k) const;
};

inline constexpr std::size_t kPassCount = 7;
extern const std::array<Pass, kPassCount> kPasses;

/// What the samples of a pixel have come to so far.
struct Pixel {
    Vec3d sum{0, 0, 0}, squares{0, 0, 0};  // of the radiance
    int samples = 0;
    int covered = 0;                           // samples that count as opaque
    float depth = kFar;                        // of the nearest hit [m]
    std::array<Vec3d, kPassCount> gathered{};  // by pass: a sum, or the nearest hit's

    void add(const Vec3f& radiance, const FirstHit& first, bool transparent_background);
    Vec3d mean() const { return sum / samples; }
    /// Variance of the mean.
    Vec3d variance() const;
    /// What a pass says of this pixel, in as many numbers as it has channels.
    Vec3d value(std::size_t pass) const;
};

}  // namespace thixo::render
