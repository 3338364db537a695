#include "pipeline/check/compare_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "pipeline/base/math.h"

namespace thixo {

namespace {

bool equal_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

std::size_t count_not_finite(const Image& image) {
    std::size_t count = 0;
    for (const ImageChannel& c : image.channels)
        count += static_cast<std::size_t>(
            std::count_if(c.values.begin(), c.values.end(), [](float x) { return !std::isfinite(x); }));
    return count;
}

void compare_names(const Image& a, const Image& b, std::vector<std::string>& problems) {
    for (const ImageChannel& c : b.channels)
        if (!a.find(c.name)) problems.push_back(fmt::format("channel {} is missing", c.name));
    for (const ImageChannel& c : a.channels) {
        const ImageChannel* other = b.find(c.name);
        if (!other)
            problems.push_back(fmt::format("channel {} is not in the reference", c.name));
        else if (c.half != other->half)
            problems.push_back(fmt::format("channel {} is stored as {}, the reference as {}", c.name,
                                           c.half ? "half" : "float", other->half ? "half" : "float"));
    }
}

struct ChannelSums {
    double squares = 0, relative = 0, peak = 1;
    std::size_t finite = 0;
    double mse() const { return finite ? squares / static_cast<double>(finite) : 0; }
    double rel_mse() const { return finite ? relative / static_cast<double>(finite) : 0; }
};

// Adds one channel to the difference. `touched` marks the pixels that differ in any channel.
void compare_channel(const ImageChannel& a, const ImageChannel& b, int width, std::vector<bool>& touched,
                     PictureDifference& d) {
    ChannelSums sums;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        const float x = a.values[i], y = b.values[i];
        const bool finite = std::isfinite(x) && std::isfinite(y);
        const double difference = finite ? std::abs(static_cast<double>(x) - y) : 0;
        if (finite) {
            ++sums.finite;
            sums.squares += square(difference);
            sums.relative += square(difference) / (square(static_cast<double>(y)) + 1e-2);
            sums.peak = std::max(sums.peak, std::abs(static_cast<double>(y)));
        }
        if (equal_bits(x, y)) continue;
        touched[i] = true;
        if (d.worst_x >= 0 && difference <= d.max_abs) continue;
        d.max_abs = difference;
        d.worst_x = static_cast<int>(i % static_cast<std::size_t>(width));
        d.worst_y = static_cast<int>(i / static_cast<std::size_t>(width));
        d.worst_channel = a.name;
    }
    d.rel_mse = std::max(d.rel_mse, sums.rel_mse());
    if (sums.mse() > 0) d.psnr = std::min(d.psnr, 10 * std::log10(square(sums.peak) / sums.mse()));
}

constexpr std::array<std::string_view, 7> kNoiseFree{"A", "Z", "N", "albedo", "P", "motion", "body"};

}  // namespace

Image without_noise(const Image& image) {
    Image kept = image;
    std::erase_if(kept.channels, [](const ImageChannel& c) {
        const std::string_view layer = std::string_view(c.name).substr(0, c.name.find('.'));
        return std::ranges::find(kNoiseFree, layer) == kNoiseFree.end() && !layer.starts_with("Crypto");
    });
    return kept;
}

FrameReport compare_pictures(const std::string& name, const Image& a, const Image& b, double max_rel_mse) {
    FrameReport report;
    report.name = name;
    if (a.width != b.width || a.height != b.height) {
        report.problems.push_back(
            fmt::format("{} x {} pixels, the reference {} x {}", a.width, a.height, b.width, b.height));
        return report;
    }
    compare_names(a, b, report.problems);
    report.has_picture = true;
    PictureDifference& d = report.picture;
    d.not_finite_a = count_not_finite(a);
    d.not_finite_b = count_not_finite(b);
    if (d.not_finite_a > 0) report.problems.push_back(fmt::format("{} values are not finite", d.not_finite_a));
    if (d.not_finite_b > 0)
        report.problems.push_back(fmt::format("{} values of the reference are not finite", d.not_finite_b));
    std::vector<bool> touched(a.pixels());
    for (const ImageChannel& c : a.channels)
        if (const ImageChannel* other = b.find(c.name)) compare_channel(c, *other, a.width, touched, d);
    d.pixels_different = static_cast<std::size_t>(std::count(touched.begin(), touched.end(), true));
    if (max_rel_mse <= 0 && d.pixels_different > 0)
        report.problems.push_back(fmt::format("{} pixels differ", d.pixels_different));
    if (max_rel_mse > 0 && !(d.rel_mse <= max_rel_mse))
        report.problems.push_back(fmt::format("relMSE {:.4g} is above {:.4g}", d.rel_mse, max_rel_mse));
    return report;
}

}  // namespace thixo
