#include "render/surfel_blocks.h"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <tuple>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo::render {
namespace {

bool usable(const SurfelCloud& cloud, Index i) {
    const float area = cloud.axis1[i].cross(cloud.axis2[i]).norm();
    return cloud.position[i].allFinite() && std::isfinite(area) && area > 0;
}

/// Splits [begin, end) at the median of its longest side, in whole blocks, down to single blocks: patches that are
/// about square make boxes that overlap less than runs of a space-filling curve (measured: about half the block tests
/// per ray that Morton order costs).
void split(const SurfelCloud& cloud, Index* begin, Index* end) {
    const std::size_t count = std::size_t(end - begin);
    if (count <= kLanes) {
        // By place: the order in which surfels were given leaves no trace in the sums over a block.
        std::sort(begin, end, [&](Index a, Index b) {
            const Vec3f &p = cloud.position[a], &q = cloud.position[b];
            return std::tuple(p.x(), p.y(), p.z(), a) < std::tuple(q.x(), q.y(), q.z(), b);
        });
        return;
    }
    Vec3f lower = Vec3f::Constant(3e38f), upper = -lower;
    for (const Index* i = begin; i != end; ++i) {
        lower = lower.cwiseMin(cloud.position[*i]);
        upper = upper.cwiseMax(cloud.position[*i]);
    }
    int axis = 0;
    (upper - lower).maxCoeff(&axis);
    const std::size_t blocks = (count + kLanes - 1) / kLanes;
    Index* const middle = begin + blocks / 2 * kLanes;
    std::nth_element(begin, middle, end, [&](Index a, Index b) {
        const float x = cloud.position[a][axis], y = cloud.position[b][axis];
        return x < y || (x == y && a < b);
    });
    if (count > 4096)
        oneapi::tbb::parallel_invoke([&] { split(cloud, begin, middle); }, [&] { split(cloud, middle, end); });
    else {
        split(cloud, begin, middle);
        split(cloud, middle, end);
    }
}

/// Surfels that can be seen, neighbours together.
std::vector<Index> spatial_order(const SurfelCloud& cloud) {
    std::vector<Index> order;
    order.reserve(cloud.size());
    for (Index i = 0; i < cloud.size(); ++i)
        if (usable(cloud, i)) order.push_back(i);
    thread_arena().execute([&] { split(cloud, order.data(), order.data() + order.size()); });
    return order;
}

void set_lane(SurfelBlock& block, int lane, const SurfelCloud& cloud, Index i, std::uint32_t layer, Box3& bounds) {
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
    THIXO_ASSERT(
        layer.size() == cloud.size() && cloud.axis1.size() == cloud.size() && cloud.axis2.size() == cloud.size(),
        "{} surfels, {} layers", cloud.size(), layer.size());
    const std::vector<Index> order = spatial_order(cloud);
    SurfelBlocks packed;
    packed.dropped = cloud.size() - order.size();
    packed.blocks.resize((order.size() + kLanes - 1) / kLanes);
    packed.bounds.resize(packed.blocks.size());
    parallel_for(packed.blocks.size(), [&](std::size_t b) {
        Box3& bounds = packed.bounds[b];
        bounds = {Vec3f::Constant(3e38f), Vec3f::Constant(-3e38f)};
        for (int lane = 0; lane < kLanes; ++lane) {
            const std::size_t k = b * kLanes + lane;
            if (k < order.size())
                set_lane(packed.blocks[b], lane, cloud, order[k], layer[order[k]], bounds);
            else
                clear_lane(packed.blocks[b], lane);
        }
    });
    return packed;
}

}  // namespace thixo::render
