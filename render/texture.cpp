#include "render/texture.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"

namespace thixo::render {
namespace {

int wrapped(int i, int n) { return i < 0 ? i + n : i >= n ? i - n : i; }

/// Texels of a row of n that the new texel i of m covers: [first, last], the first and the last by a part.
struct Cover {
    int first, last;
    float first_part, last_part;
    float part(int k) const { return k == first ? first_part : k == last ? last_part : 1; }
};
Cover cover(int i, int n, int m) {
    const float step = float(n) / float(m), begin = float(i) * step, end = begin + step;
    const int first = int(begin), last = std::min(int(std::ceil(end)), n) - 1;
    return {first, last, std::min(end, float(first + 1)) - begin, end - float(last)};
}

}  // namespace

Texture::Texture(int width, int height, std::vector<Vec3f> colours) {
    THIXO_ASSERT(width > 0 && height > 0 && colours.size() == std::size_t(width) * std::size_t(height),
                 "{} colours for {} x {} texels", colours.size(), width, height);
    levels_.push_back({width, height, std::move(colours)});
    while (levels_.back().width > 1 || levels_.back().height > 1) levels_.push_back(smaller(levels_.back()));
}

Texture::Level Texture::smaller(const Level& level) {
    Level half{std::max(1, level.width / 2), std::max(1, level.height / 2), {}};
    for (int y = 0; y < half.height; ++y) {
        const Cover rows = cover(y, level.height, half.height);
        for (int x = 0; x < half.width; ++x) {
            const Cover columns = cover(x, level.width, half.width);
            Vec3f sum = Vec3f::Zero();
            float area = 0;
            for (int r = rows.first; r <= rows.last; ++r)
                for (int c = columns.first; c <= columns.last; ++c) {
                    const float w = rows.part(r) * columns.part(c);
                    sum += w * level.colours[std::size_t(r) * std::size_t(level.width) + std::size_t(c)];
                    area += w;
                }
            half.colours.push_back(sum / area);
        }
    }
    return half;
}

Vec3f Texture::Level::bilinear(const Vec2f& uv) const {
    const float u = uv.x() - std::floor(uv.x()), v = uv.y() - std::floor(uv.y());
    const float x = u * float(width) - 0.5f, y = (1 - v) * float(height) - 0.5f;
    const int column = int(std::floor(x)), row = int(std::floor(y));
    const float s = x - float(column), t = y - float(row);
    const auto at = [&](int c, int r) -> const Vec3f& {
        return colours[std::size_t(wrapped(r, height)) * std::size_t(width) + std::size_t(wrapped(c, width))];
    };
    return (1 - t) * ((1 - s) * at(column, row) + s * at(column + 1, row)) +
           t * ((1 - s) * at(column, row + 1) + s * at(column + 1, row + 1));
}

Vec3f Texture::colour(const Vec2f& uv, const Vec2f& footprint) const {
    if (!uv.allFinite()) return levels_.back().colours[0];
    // The finer direction decides: what is blurred too little the samples of a pixel still average.
    const float texels = std::min(footprint.x() * float(width()), footprint.y() * float(height()));
    const float level = texels > 1 ? std::log2(texels) : 0;
    const std::size_t fine = std::min(std::size_t(level), levels_.size() - 1);
    const float mix = level - float(fine);
    if (mix <= 0 || fine + 1 == levels_.size()) return levels_[fine].bilinear(uv);
    return (1 - mix) * levels_[fine].bilinear(uv) + mix * levels_[fine + 1].bilinear(uv);
}

}  // namespace thixo::render
