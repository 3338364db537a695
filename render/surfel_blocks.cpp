#include "render/surfel_blocks.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo::render {
namespace {

using Code = std::pair<std::uint64_t, Index>;

/// Spreads 21 bits so that two zero bits follow each.
std::uint64_t spread(std::uint64_t a) {
    a &= 0x1fffff;
    a = (a | a << 32) & 0x1f00000000ffffull;
    a = (a | a << 16) & 0x1f0000ff0000ffull;
    a = (a | a << 8) & 0x100f00f00f00f00full;
    a = (a | a << 4) & 0x10c30c30c30c30c3ull;
    a = (a | a << 2) & 0x1249249249249249ull;
    return a;
}

bool usable(const SurfelCloud& cloud, Index i) {
    const float area = cloud.axis1[i].cross(cloud.axis2[i]).norm();
    return cloud.position[i].allFinite() && std::isfinite(area) && area > 0;
}

/// Surfels that can be seen, in the order of their Morton codes; ties by index.
std::vector<Code> morton_order(const SurfelCloud& cloud) {
    std::vector<Code> codes;
    codes.reserve(cloud.size());
    Vec3f lower = Vec3f::Constant(3e38f), upper = -lower;
    for (Index i = 0; i < cloud.size(); ++i) {
        if (!usable(cloud, i)) continue;
        codes.push_back({0, i});
        lower = lower.cwiseMin(cloud.position[i]);
        upper = upper.cwiseMax(cloud.position[i]);
    }
    const float scale = 2097151.0f / std::max((upper - lower).maxCoeff(), 1e-30f);
    parallel_for(codes.size(), [&](std::size_t k) {
        const Vec3f q = (cloud.position[codes[k].second] - lower) * scale;
        codes[k].first = spread(std::uint64_t(q.x())) | spread(std::uint64_t(q.y())) << 1 | spread(std::uint64_t(q.z())) << 2;
    });
    oneapi::tbb::parallel_sort(codes.begin(), codes.end());
    return codes;
}

void set_lane(SurfelBlock& block, int lane, const SurfelCloud& cloud, Index i, std::uint32_t layer, Bounds& bounds) {
    const Vec3f &s = cloud.position[i], &t1 = cloud.axis1[i], &t2 = cloud.axis2[i];
    const Vec3f n = t1.cross(t2).normalized();
    const float height = kHeight * std::sqrt(t1.norm() * t2.norm());
    // Rows of the inverse of (kReach t1, kReach t2, height n): right also where t1 and t2 are not at right angles.
    Mat3f axes;
    axes << kReach * t1, kReach * t2, height * n;
    const Mat3f to_unit = axes.inverse();
    for (int k = 0; k < 3; ++k) {
        block.centre[k][lane] = s[k];
        for (int row = 0; row < 3; ++row) block.to_unit[row][k][lane] = to_unit(row, k);
    }
    block.height[lane] = height;
    block.layer[lane] = layer;
    block.source[lane] = i;
    const Vec3f half = axes.rowwise().norm();
    bounds.lower = bounds.lower.cwiseMin(s - half);
    bounds.upper = bounds.upper.cwiseMax(s + half);
}

void clear_lane(SurfelBlock& block, int lane) {
    for (int k = 0; k < 3; ++k) {
        block.centre[k][lane] = 1e15f;  // nothing gets there
        for (int row = 0; row < 3; ++row) block.to_unit[row][k][lane] = row == k ? 1.0f : 0.0f;
    }
    block.height[lane] = 1;
    block.layer[lane] = 0;
    block.source[lane] = kNone;
}

}  // namespace

SurfelBlocks pack_surfels(const SurfelCloud& cloud, std::span<const std::uint32_t> layer) {
    THIXO_ASSERT(layer.size() == cloud.size() && cloud.axis1.size() == cloud.size() && cloud.axis2.size() == cloud.size(),
                 "{} surfels, {} layers", cloud.size(), layer.size());
    const std::vector<Code> order = morton_order(cloud);
    SurfelBlocks packed;
    packed.dropped = cloud.size() - order.size();
    packed.blocks.resize((order.size() + kLanes - 1) / kLanes);
    packed.bounds.resize(packed.blocks.size());
    parallel_for(packed.blocks.size(), [&](std::size_t b) {
        Bounds& bounds = packed.bounds[b];
        bounds = {Vec3f::Constant(3e38f), Vec3f::Constant(-3e38f)};
        for (int lane = 0; lane < kLanes; ++lane) {
            const std::size_t k = b * kLanes + lane;
            if (k < order.size())
                set_lane(packed.blocks[b], lane, cloud, order[k].second, layer[order[k].second], bounds);
            else
                clear_lane(packed.blocks[b], lane);
        }
    });
    return packed;
}

}  // namespace thixo::render
