#include "pipeline/check/difference_picture.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/colour_code.h"

namespace thixo {

namespace {

using Rgb = std::array<float, 3>;

struct Difference {
    float size = 0;    // largest over the channels
    bool any = false;  // some bit differs
    bool finite = true;
};

std::vector<Difference> differences(const Image& a, const Image& b) {
    std::vector<Difference> all(a.pixels());
    for (const ImageChannel& c : a.channels) {
        const ImageChannel* other = b.find(c.name);
        if (!other) continue;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const float x = c.values[i], y = other->values[i];
            all[i].finite = all[i].finite && std::isfinite(x) && std::isfinite(y);
            all[i].any = all[i].any || std::bit_cast<std::uint32_t>(x) != std::bit_cast<std::uint32_t>(y);
            if (all[i].finite) all[i].size = std::max(all[i].size, std::abs(x - y));
        }
    }
    return all;
}

Rgb shown(const Image& image, std::size_t i) {
    Rgb colour{};
    const char* names[] = {"R", "G", "B"};
    for (std::size_t k = 0; k < 3; ++k) {
        const ImageChannel* c = image.find(names[k]);
        if (!c && !image.channels.empty()) c = &image.channels.front();
        const float x = c ? c->values[i] : 0;
        colour[k] = std::isfinite(x) ? srgb_from_linear(x) : 1;
    }
    return colour;
}

// From black over dark red and orange to white. Values that are not finite are cyan.
Rgb heat(const Difference& d, float largest) {
    if (!d.finite) return {0, 1, 1};
    if (!d.any) return {0, 0, 0};
    const float t = 0.2f + 0.8f * (largest > 0 ? std::sqrt(d.size / largest) : 0.0f);
    return {std::min(1.0f, 2 * t), std::clamp(2.5f * t - 0.9f, 0.0f, 1.0f), std::clamp(4 * t - 3, 0.0f, 1.0f)};
}

}  // namespace

Image8 difference_picture(const Image& a, const Image& b) {
    THIXO_ASSERT(a.width == b.width && a.height == b.height, "pictures of {} x {} and {} x {}", a.width, a.height,
                 b.width, b.height);
    const std::vector<Difference> all = differences(a, b);
    float largest = 0;
    for (const Difference& d : all) largest = std::max(largest, d.finite ? d.size : 0);
    Image8 out;
    out.width = 3 * a.width;
    out.height = a.height;
    out.values.resize(9 * a.pixels());
    const auto put = [&](std::size_t x, std::size_t y, const Rgb& colour) {
        for (std::size_t k = 0; k < 3; ++k)
            out.values[3 * (y * static_cast<std::size_t>(out.width) + x) + k] =
                static_cast<std::uint8_t>(255 * colour[k] + 0.5f);
    };
    const std::size_t width = static_cast<std::size_t>(a.width);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::size_t x = i % width, y = i / width;
        put(x, y, shown(a, i));
        put(x + width, y, shown(b, i));
        put(x + 2 * width, y, heat(all[i], largest));
    }
    return out;
}

}  // namespace thixo
