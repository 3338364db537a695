#include "render/preview/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "render/preview/colour_map.h"

namespace thixo::preview {

namespace {

// Characters ' ' to '~', drawn for this program: 7 rows of 5 dots, the top row in the highest bits, the left dot first.
constexpr std::array<std::uint64_t, 95> kFont{
    0x000000000ull, 0x7e318c63full, 0x7e318c63full, 0x7e318c63full, 0x7e318c63full, 0x672222273ull, 0x7e318c63full,
    0x7e318c63full, 0x088842082ull, 0x208210888ull, 0x02aefbaa0ull, 0x0084f9080ull, 0x000003088ull, 0x0000f0000ull,
    0x00000018cull, 0x042222210ull, 0x3a33ae62eull, 0x11842108eull, 0x3a213221full, 0x78217043eull, 0x08ca97c42ull,
    0x7e1e0862eull, 0x3a10f462eull, 0x7c2221084ull, 0x3a317462eull, 0x3a317842eull, 0x018c03180ull, 0x7e318c63full,
    0x7e318c63full, 0x001f07c00ull, 0x7e318c63full, 0x7e318c63full, 0x7e318c63full, 0x3a31fc631ull, 0x7a31f463eull,
    0x3a308422eull, 0x7a318c63eull, 0x7e10f421full, 0x7e10f4210ull, 0x3a30bc62eull, 0x4631fc631ull, 0x38842108eull,
    0x1c4210a4cull, 0x4654c5251ull, 0x42108421full, 0x4775ac631ull, 0x4739ace71ull, 0x3a318c62eull, 0x7a31f4210ull,
    0x3a318d64dull, 0x7a31f5251ull, 0x3e107043eull, 0x7c8421084ull, 0x46318c62eull, 0x46318a944ull, 0x4631ad771ull,
    0x462a22a31ull, 0x462a21084ull, 0x7c222221full, 0x1c8421087ull, 0x7e318c63full, 0x70842109cull, 0x115100000ull,
    0x00000001full, 0x7e318c63full, 0x000e0be2full, 0x421e8c63eull, 0x000f8420full, 0x042f8c62full, 0x000e8fe0eull,
    0x191e42108ull, 0x000f8bc2eull, 0x4216cc631ull, 0x100c2108eull, 0x080610a4cull, 0x4212a6292ull, 0x30842108eull,
    0x001aad6b5ull, 0x0016cc631ull, 0x000e8c62eull, 0x001e8fa10ull, 0x000f8bc21ull, 0x0016cc210ull, 0x000f8383eull,
    0x211e42106ull, 0x00118c66dull, 0x00118c544ull, 0x0011ad6aaull, 0x001151151ull, 0x00118bc2eull, 0x001f1111full,
    0x7e318c63full, 0x108421084ull, 0x7e318c63full, 0x7e318c63full,
};

const Vec3f kInk{0.16f, 0.17f, 0.19f};

void set_pixel(Image8& picture, int x, int y, const Vec3f& colour) {
    if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return;
    const std::size_t at =
        static_cast<std::size_t>(picture.channels) *
        (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x));
    const std::uint32_t packed = pack_colour(colour);
    for (std::size_t k = 0; k < 3; ++k) picture.values[at + k] = static_cast<std::uint8_t>(packed >> (8 * k));
}

void fill(Image8& picture, int x, int y, int width, int height, const Vec3f& colour) {
    for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) set_pixel(picture, x + i, y + j, colour);
}

Vec3f unpacked(std::uint32_t c) {
    return Vec3f(static_cast<float>(c & 255), static_cast<float>(c >> 8 & 255), static_cast<float>(c >> 16 & 255)) /
           255.0f;
}

void draw_scale(Image8& picture, const Legend& legend, int x, int y, int scale) {
    const int width = std::min(picture.width / 3, 150 * scale), height = 6 * scale;
    const std::string low = fmt::format("{:.4g}", legend.range.lower), high = fmt::format("{:.4g}", legend.range.upper);
    draw_text(picture, x, y - 20 * scale, scale, kInk, legend.title);
    fill(picture, x - 1, y - height - 1, width + 2, height + 2, kInk);
    for (int i = 0; i < width; ++i)
        fill(picture, x + i, y - height, 1, height, map_colour(static_cast<double>(i) / std::max(1, width - 1)));
    draw_text(picture, x, y + 4 * scale, scale, kInk, low);
    draw_text(picture, x + width - text_width(high, scale), y + 4 * scale, scale, kInk, high);
}

void draw_categories(Image8& picture, const Legend& legend, int x, int y, int scale) {
    draw_text(picture, x, y - 12 * scale, scale, kInk, legend.title);
    for (const auto& [label, colour] : legend.categories) {
        fill(picture, x, y, 7 * scale, 7 * scale, unpacked(colour));
        x = draw_text(picture, x + 10 * scale, y, scale, kInk, label) + 8 * scale;
    }
}

}  // namespace

void draw_fronts(Image8& picture, const View& view, const std::vector<FrameFront>& fronts) {
    const int width = std::max(1, picture.height / 360);
    const auto dot = [&](const Vec2d& at, int radius) {
        for (int y = -radius; y <= radius; ++y)
            for (int x = -radius; x <= radius; ++x)
                if (x * x + y * y <= radius * radius)
                    set_pixel(picture, static_cast<int>(std::floor(at.x())) + x,
                              static_cast<int>(std::floor(at.y())) + y, kFrontColour);
    };
    const auto line = [&](const Vec2d& from, const Vec2d& to) {
        // What lies far outside of the picture is not drawn dot by dot.
        const double longest = 4.0 * (picture.width + picture.height);
        const int steps = static_cast<int>(std::ceil(std::min((to - from).cwiseAbs().maxCoeff(), longest)));
        for (int k = 0; k <= steps; ++k)
            dot(from + (to - from) * (k / std::max(1.0, static_cast<double>(steps))), width);
    };
    for (const FrameFront& front : fronts) {
        std::vector<std::optional<Vec2d>> at;
        for (const auto& node : front.nodes) {
            const Vec3d x(node[0], node[1], node[2]);
            const bool ahead = view.to_eye(x).z() < 0;
            at.push_back(ahead
                             ? std::optional<Vec2d>(view.project(x).cwiseProduct(Vec2d(picture.width, picture.height)))
                             : std::nullopt);
        }
        for (std::size_t k = 0; k < at.size(); ++k) {
            if (at[k]) dot(*at[k], 2 * width);
            const std::size_t next = (k + 1) % at.size();
            if (at[k] && at[next] && (next > k || front.closed)) line(*at[k], *at[next]);
        }
    }
}

int text_width(const std::string& text, int scale) {
    return std::max(0, 6 * static_cast<int>(text.size()) - 1) * scale;
}

int draw_text(Image8& picture, int x, int y, int scale, const Vec3f& colour, const std::string& text) {
    for (const char c : text) {
        const bool known = c >= ' ' && c <= '~';
        const std::uint64_t dots = kFont[known ? static_cast<std::size_t>(c - ' ') : kFont.size() - 1];
        for (int row = 0; row < 7; ++row)
            for (int column = 0; column < 5; ++column)
                if (dots >> (34 - 5 * row - column) & 1)
                    fill(picture, x + column * scale, y + row * scale, scale, scale, colour);
        x += 6 * scale;
    }
    return x - (text.empty() ? 0 : scale);
}

void draw_labels(Image8& picture, const Legend& legend, const Frame& frame, std::size_t count, const char* what) {
    const int scale = std::max(1, picture.height / 360), margin = 10 * scale;
    const std::string words = fmt::format("frame {}   {:.3f} s   {} {}", frame.number, frame.time, count, what);
    draw_text(picture, margin, margin, scale, kInk, words);
    const int foot = picture.height - margin - 11 * scale;
    if (legend.kind == Legend::Kind::scale) draw_scale(picture, legend, margin, foot, scale);
    if (legend.kind == Legend::Kind::categories) draw_categories(picture, legend, margin, foot + 4 * scale, scale);
    if (legend.kind == Legend::Kind::none) draw_text(picture, margin, foot + 4 * scale, scale, kInk, legend.title);
}

}  // namespace thixo::preview
