#include "pipeline/check/compare_noisy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pipeline/base/math.h"
#include "pipeline/check/welch.h"

namespace thixo {
namespace {

constexpr std::array<const char*, 3> kColours{"R", "G", "B"};

/// Areas of one size, and the least probable of them that fails.
struct Level {
    const char* name;
    int side;  // [pixels]
    double worst = 1;
    std::string problem{};
};

/// One colour of a picture with its noise.
struct NoisyChannel {
    const ImageChannel *mean, *variance, *samples;

    /// Variance that storing a value adds: a rounding error is equally probable within a unit in the last place.
    double rounding(std::size_t i) const {
        constexpr int kHalfBits = 10, kLeast = -14;
        if (!mean->half || mean->values[i] == 0) return 0;
        const int exponent = std::max(std::ilogb(mean->values[i]), kLeast);
        return square(std::ldexp(1.0, exponent - kHalfBits)) / 12;
    }
};

std::optional<NoisyChannel> noisy_channel(const Image& image, const std::string& colour) {
    // The variance of a denoised picture is that of its colours as they were before.
    const ImageChannel* before = image.find("noisy." + colour);
    const NoisyChannel c{before ? before : image.find(colour), image.find("variance." + colour), image.find("samples")};
    if (!c.mean || !c.variance || !c.samples) return {};
    return c;
}

/// Whether every pixel tells its noise.
bool is_usable(const NoisyChannel& c) {
    return std::ranges::all_of(c.samples->values, [](float n) { return n >= 2; }) &&
           std::ranges::all_of(c.variance->values, [](float v) { return v >= 0 && std::isfinite(v); }) &&
           std::ranges::all_of(c.mean->values, [](float v) { return std::isfinite(v); });
}

/// One colour of both pictures.
struct NoisyPair {
    NoisyChannel a, b;
    const char* colour;
    std::size_t width, height;

    /// The sum over the pixels of the area whose first one is (x, y).
    WelchSum sum(std::size_t x, std::size_t y, std::size_t side) const {
        WelchSum sum;
        for (std::size_t row = y; row < std::min(y + side, height); ++row)
            for (std::size_t i = row * width + x; i < row * width + std::min(x + side, width); ++i) {
                sum.difference += double(a.mean->values[i]) - double(b.mean->values[i]);
                for (const NoisyChannel* c : {&a, &b})
                    sum.add_variance(double(c->variance->values[i]), double(c->samples->values[i]) - 1, c->rounding(i));
            }
        return sum;
    }
};

/// Tests all areas of a level, which fail together with this probability at most where there is noise alone.
void test_level(const NoisyPair& pair, double false_alarms, Level& level, NoiseDifference& found) {
    const auto side = static_cast<std::size_t>(level.side);
    const std::size_t columns = (pair.width + side - 1) / side, rows = (pair.height + side - 1) / side;
    found.tests += columns * rows;
    for (std::size_t k = 0; k < columns * rows; ++k) {
        const std::size_t x = k % columns * side, y = k / columns * side;
        const WelchSum sum = pair.sum(x, y, side);
        const double p = sum.probability();
        found.least_probable = std::min(found.least_probable, p);
        if (p * static_cast<double>(columns * rows) >= false_alarms) continue;
        ++found.failed;
        if (!level.problem.empty() && p >= level.worst) continue;
        const double pixels = static_cast<double>(std::min(side, pair.width - x) * std::min(side, pair.height - y));
        level.worst = p;
        level.problem = fmt::format("{} of {} at ({}, {}) differs by {:.3g} in the mean, noise is {:.3g}", pair.colour,
                                    level.name, x, y, sum.difference / pixels, std::sqrt(sum.variance) / pixels);
    }
}

}  // namespace

NoiseDifference compare_noisy(const Image& a, const Image& b, double false_alarms, std::vector<std::string>& problems) {
    std::array<Level, 3> levels{{{"the picture", std::max(a.width, a.height)}, {"a region", 64}, {"a tile", 16}}};
    NoiseDifference found;
    for (const char* colour : kColours) {
        const auto of_a = noisy_channel(a, colour), of_b = noisy_channel(b, colour);
        if (!of_a || !of_b || !is_usable(*of_a) || !is_usable(*of_b)) {
            problems.push_back(
                fmt::format("the noise of {} is not known: no variance pass, or one sample a pixel", colour));
            continue;
        }
        const NoisyPair pair{*of_a, *of_b, colour, static_cast<std::size_t>(a.width),
                             static_cast<std::size_t>(a.height)};
        for (Level& level : levels)
            test_level(pair, false_alarms / double(levels.size() * kColours.size()), level, found);
    }
    for (const Level& level : levels)
        if (!level.problem.empty()) problems.push_back(level.problem);
    return found;
}

}  // namespace thixo
