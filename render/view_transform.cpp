#include "render/view_transform.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"

namespace thixo::render {
namespace {

float srgb_transfer(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f; }

std::uint8_t to_byte(float x) { return std::uint8_t(std::lround(255 * clamp01(x))); }

}  // namespace

float view_transform(float x, scene::ViewTransform view, double exposure) {
    float y = std::max(0.0f, x) * float(std::exp2(exposure));
    if (view == scene::ViewTransform::filmic) {
        constexpr float a = 0.5f;
        if (y > a) y = a + (1 - a) * (1 - std::exp(-(y - a) / (1 - a)));
    }
    return srgb_transfer(std::min(y, 1.0f));
}

Image8 to_display(const Image& image, scene::ViewTransform view, double exposure) {
    const float* rgb[] = {image.get("R").data(), image.get("G").data(), image.get("B").data()};
    const ImageChannel* alpha = image.find("A");
    const bool keep = alpha && std::any_of(alpha->values.begin(), alpha->values.end(), [](float a) { return a < 1; });
    Image8 out;
    out.width = image.width;
    out.height = image.height;
    out.channels = keep ? 4 : 3;
    out.values.resize(image.pixels() * std::size_t(out.channels));
    parallel_for(image.pixels(), [&](std::size_t i) {
        const float a = keep ? alpha->values[i] : 1;
        std::uint8_t* to = &out.values[i * std::size_t(out.channels)];
        for (int k = 0; k < 3; ++k) to[k] = to_byte(view_transform(a > 0 ? rgb[k][i] / a : 0, view, exposure));
        if (keep) to[3] = to_byte(a);
    });
    return out;
}

}  // namespace thixo::render
