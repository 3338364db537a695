#include "render/denoise/patch_weights.h"

#include <array>

namespace thixo::render {
namespace {

constexpr float kLeast = 1e-10f;  // variance that any value has

}  // namespace

void patch_distances(const PatchMetric& m, int x, int y, int dx, int dy, float* distances) {
    constexpr int rows = kTileHeight + 2 * kPatch, columns = kTileWidth + kFloatLanes;
    static_assert(2 * kPatch <= kFloatLanes);
    alignas(32) std::array<float, columns> point;
    alignas(32) std::array<std::array<float, kTileWidth>, rows> across;
    const float width2 = square(m.width);
    for (int r = 0; r < rows; ++r) {
        const int row = y - kPatch + r;
        for (int c = 0; c < columns; c += kFloatLanes) {
            const int column = x - kPatch + c;
            FloatLanes d{};
            for (int k = m.first; k < m.first + m.count; ++k) {
                const FloatLanes u =
                    lanes_at(m.values.at(k, column, row)) - lanes_at(m.values.at(k, column + dx, row + dy));
                const FloatLanes p = lanes_at(m.variances.at(k, column, row)),
                                 q = lanes_at(m.variances.at(k, column + dx, row + dy));
                d += (u * u - (p + smaller(p, q))) / (kLeast + width2 * (p + q));
            }
            put_lanes(d, &point[std::size_t(c)]);
        }
        for (int c = 0; c < kTileWidth; c += kFloatLanes) {
            FloatLanes sum = lanes_at(&point[std::size_t(c)]);
            for (int t = 1; t <= 2 * kPatch; ++t) sum += lanes_at(&point[std::size_t(c + t)]);
            put_lanes(sum, &across[std::size_t(r)][std::size_t(c)]);
        }
    }
    const float share = 1 / float(square(2 * kPatch + 1) * m.count);
    for (int r = 0; r < kTileHeight; ++r)
        for (int c = 0; c < kTileWidth; c += kFloatLanes) {
            FloatLanes sum = lanes_at(&across[std::size_t(r)][std::size_t(c)]);
            for (int t = 1; t <= 2 * kPatch; ++t) sum += lanes_at(&across[std::size_t(r + t)][std::size_t(c)]);
            put_lanes(share * sum, distances + r * kTileWidth + c);
        }
}

Planes nonlocal_mean(const Planes& planes, const PatchMetric& metric, int radius) {
    Planes out(metric.count, planes.width(), planes.height());
    for_each_tile(planes.width(), planes.height(), [&](int x, int y) {
        alignas(32) std::array<float, kTileWidth * kTileHeight> distance, total{};
        for (int dy = -radius; dy <= radius; ++dy)
            for (int dx = -radius; dx <= radius; ++dx) {
                patch_distances(metric, x, y, dx, dy, distance.data());
                for (int i = 0; i < kTileWidth * kTileHeight; i += kFloatLanes) {
                    const FloatLanes w = kernel(lanes_at(&distance[std::size_t(i)]));
                    const int column = x + i % kTileWidth, row = y + i / kTileWidth;
                    put_lanes(w + lanes_at(&total[std::size_t(i)]), &total[std::size_t(i)]);
                    for (int k = 0; k < metric.count; ++k) {
                        float* const to = out.at(k, column, row);
                        put_lanes(lanes_at(to) + w * lanes_at(planes.at(metric.first + k, column + dx, row + dy)), to);
                    }
                }
            }
        for (int i = 0; i < kTileWidth * kTileHeight; i += kFloatLanes)
            for (int k = 0; k < metric.count; ++k) {
                float* const to = out.at(k, x + i % kTileWidth, y + i / kTileWidth);
                put_lanes(lanes_at(to) / lanes_at(&total[std::size_t(i)]), to);
            }
    });
    out.extend();
    return out;
}

}  // namespace thixo::render
