// The passes of a picture, in one table. An entry says what a pass is called, how it is stored and how it is gathered
// from the samples of a pixel. Another pass is another entry, and says how many there are.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "render/cryptomatte.h"
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
using PassValue = Eigen::Vector4d;  // as many of its numbers count as the pass has channels

struct Pass {
    std::string_view layer;    // empty: the channels stand alone
    std::string_view letters;  // a channel each; empty: one channel of the layer's name
    bool half;                 // half or float in the file
    Gathered gathered;
    PassValue (*of_hit)(const FirstHit&) = nullptr;  // mean, nearest
    PassValue (*of_pixel)(const Pixel&) = nullptr;   // pixel
    double nothing = 0;                              // nearest: where nothing is hit
    bool scene::Passes::*asked = nullptr;            // the key that asks for it; null: always there

    int channels() const { return letters.empty() ? 1 : int(letters.size()); }
    /// Of channel k, as EXR names it: "R", "N.X", "samples".
    std::string channel(int k) const;
    bool on(const scene::Passes& passes) const { return asked == nullptr || passes.*asked; }
};

inline constexpr std::size_t kPassCount = 17;
extern const std::array<Pass, kPassCount> kPasses;

/// What the samples of a pixel have come to so far.
struct Pixel {
    Vec3d sum{0, 0, 0}, squares{0, 0, 0};  // of the radiance
    int samples = 0;
    int covered = 0;                             // samples that count as opaque
    float depth = kFar;                          // of the nearest hit [m]
    std::array<PassValue, kPassCount> gathered;  // by pass: a sum, or the nearest hit's
    std::vector<Coverage> objects, materials;    // for Cryptomatte

    Pixel() { gathered.fill(PassValue::Zero()); }
    void add(const Vec3f& radiance, const FirstHit& first, const World& world);
    Vec3d mean() const { return sum / samples; }
    /// Variance of the mean.
    Vec3d variance() const;
    /// What a pass says of this pixel.
    PassValue value(std::size_t pass) const;
};

/// What the header says of the passes that are on.
std::map<std::string, std::string> pass_attributes(const World& world);

}  // namespace thixo::render
