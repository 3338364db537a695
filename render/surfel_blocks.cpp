#include "render/surfel_blocks.h"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo::render {
namespace {

bool usable(const SurfelCloud& cloud, Index i) {
    const float area = cloud.axis1[i].cross(cloud.axis2[i]).norm();
    return cloud.position[i].allFinite() && std::isfinite(area) && area > 0;
}

struct alignas(16) Place {
    float x[3];
    Index surfel;
};

/// By coordinate, then by surfel: one order whatever was before.
struct Along {
    int axis;
    bool operator()(const Place& a, const Place& b) const {
        return a.x[axis] < b.x[axis] || (a.x[axis] == b.x[axis] && a.surfel < b.surfel);
    }
};

struct Extent {
    int axis;  // the longest
    float lower, length;
};
Extent extent(std::span<const Place> places) {
    FourFloats lower = FourFloats{} + 3e38f, upper = -lower;
    for (const Place& p : places) {
        FourFloats x;
        std::memcpy(&x, &p, sizeof x);
        lower = smaller(lower, x);
        upper = larger(upper, x);
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (upper[k] - lower[k] > upper[axis] - lower[axis]) axis = k;
    return {axis, lower[axis], upper[axis] - lower[axis]};
}

/// Up to here a histogram costs more than it saves.
constexpr std::size_t kSmall = 96;

/// As std::nth_element into `to`, but without a branch to guess. A histogram sorts into what is below, in, and above
/// the bin of the median, which alone is then sorted out.
void part(std::span<const Place> from, std::span<Place> to, std::size_t middle, const Extent& e) {
    constexpr int bins = 64;
    std::array<std::uint32_t, bins + 1> ends{};
    const float scale = (bins - 0.01f) / e.length;
    const auto bin = [&](const Place& p) { return int((p.x[e.axis] - e.lower) * scale); };
    for (const Place& p : from) ++ends[std::size_t(bin(p)) + 1];
    int median = 0;
    for (; ends[std::size_t(median) + 1] <= middle; ++median)
        ends[std::size_t(median) + 2] += ends[std::size_t(median) + 1];
    Place* out[3] = {to.data(), to.data() + ends[std::size_t(median)], to.data() + ends[std::size_t(median) + 1]};
    for (const Place& p : from) {
        const int k = bin(p);
        *out[(k >= median) + (k > median)]++ = p;
    }
    std::nth_element(to.data() + ends[std::size_t(median)], to.data() + middle,
                     to.data() + ends[std::size_t(median) + 1], Along{e.axis});
}

/// By place: the order in which surfels were given leaves no trace in the sums over a block.
void sort_block(std::span<Place> places) {
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return std::tuple(a.x[0], a.x[1], a.x[2], a.surfel) < std::tuple(b.x[0], b.x[1], b.x[2], b.surfel);
    });
}

/// Splits at the median of the longest side, in whole blocks, down to single blocks. Patches that are about square make
/// boxes that overlap little: a ray tests about half as many blocks as along a space-filling curve. `places` are in
/// `spare` after every large split; they end where they began.
void split(std::span<Place> places, std::span<Place> spare, bool in_spare) {
    const std::size_t count = places.size();
    if (in_spare && count <= kSmall) {
        std::copy(spare.begin(), spare.end(), places.begin());
        in_spare = false;
    }
    if (count <= kFloatLanes) return sort_block(places);
    const std::size_t middle = (count + kFloatLanes - 1) / kFloatLanes / 2 * kFloatLanes;
    const std::span<Place> now = in_spare ? spare : places;
    const Extent e = extent(now);
    if (count <= kSmall || !(e.length > 1e-30f && e.length < 1e30f)) {
        std::nth_element(now.begin(), now.begin() + std::ptrdiff_t(middle), now.end(), Along{e.axis});
    } else {
        part(now, in_spare ? places : spare, middle, e);
        in_spare = !in_spare;
    }
    const auto left = [&] { split(places.first(middle), spare.first(middle), in_spare); };
    const auto right = [&] { split(places.subspan(middle), spare.subspan(middle), in_spare); };
    if (count > 4096)
        oneapi::tbb::parallel_invoke(left, right);
    else {
        left();
        right();
    }
}

/// Surfels that can be seen, neighbours together.
std::vector<Place> spatial_order(const SurfelCloud& cloud) {
    constexpr std::size_t chunk = 1 << 14;
    std::vector<std::size_t> first((cloud.size() + chunk - 1) / chunk + 1, 0);
    std::vector<std::uint8_t> seen(cloud.size());
    parallel_chunks(
        cloud.size(),
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            for (std::size_t i = begin; i < end; ++i) first[c + 1] += seen[i] = usable(cloud, Index(i));
        },
        chunk);
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Place> places(first.back()), spare(first.back());
    parallel_chunks(
        cloud.size(),
        [&](std::size_t begin, std::size_t end, std::size_t c) {
            std::size_t at = first[c];
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3f& x = cloud.position[i];
                if (seen[i]) places[at++] = {{x.x(), x.y(), x.z()}, Index(i)};
            }
        },
        chunk);
    thread_arena().execute([&] { split(places, spare, false); });
    return places;
}

void set_lane(SurfelBlock& block, int lane, const SurfelCloud& cloud, Index i, std::uint32_t layer, Box3& bounds) {
    const Vec3f &centre = cloud.position[i], &t1 = cloud.axis1[i], &t2 = cloud.axis2[i];
    const Vec3f across = t1.cross(t2);
    const float area = across.norm(), height = kHeight * std::sqrt(t1.norm() * t2.norm());
    const Vec3f n = across / area;
    // Rows of the inverse of (kReach t1, kReach t2, height n): right also where t1 and t2 are not at right angles.
    const Vec3f to_unit[3] = {t2.cross(n) / (kReach * area), n.cross(t1) / (kReach * area), n / height};
    for (int k = 0; k < 3; ++k) {
        block.centre[k][lane] = centre[k];
        for (int row = 0; row < 3; ++row) block.to_unit[row][k][lane] = to_unit[row][k];
    }
    block.height[lane] = height;
    block.layer[lane] = layer;
    block.source[lane] = i;
    const Vec3f half =
        (square(kReach) * (t1.cwiseAbs2() + t2.cwiseAbs2()) + square(height) * n.cwiseAbs2()).cwiseSqrt();
    bounds.lower = bounds.lower.cwiseMin(centre - half);
    bounds.upper = bounds.upper.cwiseMax(centre + half);
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

BlockSummary summarise(const SurfelBlock& block, int lanes) {
    const auto normal = [&](int lane) {
        return Vec3f(block.height[lane] *
                     Vec3f(block.to_unit[2][0][lane], block.to_unit[2][1][lane], block.to_unit[2][2][lane]));
    };
    Vec3f lower = normal(0), upper = lower;
    std::uint32_t layer = block.layer[0];
    for (int lane = 1; lane < lanes; ++lane) {
        lower = lower.cwiseMin(normal(lane));
        upper = upper.cwiseMax(normal(lane));
        if (block.layer[lane] != layer) layer = kNone;
    }
    const Vec3f centre = 0.5f * (lower + upper);
    float radius2 = 0;
    for (int lane = 0; lane < lanes; ++lane) radius2 = std::max(radius2, (normal(lane) - centre).squaredNorm());
    // With room for the rounding of n.d and of what it is compared with.
    return {{centre.x(), centre.y(), centre.z()}, std::sqrt(radius2) + 1e-5f, layer};
}

}  // namespace

SurfelBlocks pack_surfels(const SurfelCloud& cloud, std::span<const std::uint32_t> layer) {
    THIXO_ASSERT(
        layer.size() == cloud.size() && cloud.axis1.size() == cloud.size() && cloud.axis2.size() == cloud.size(),
        "{} surfels, {} layers", cloud.size(), layer.size());
    const std::vector<Place> order = spatial_order(cloud);
    SurfelBlocks packed;
    packed.dropped = cloud.size() - order.size();
    packed.bounds.resize((order.size() + kFloatLanes - 1) / kFloatLanes);
    packed.storage = std::make_unique_for_overwrite<SurfelBlock[]>(packed.bounds.size());
    packed.summary = std::make_unique_for_overwrite<BlockSummary[]>(packed.bounds.size());
    parallel_for(packed.bounds.size(), [&](std::size_t b) {
        Box3& bounds = packed.bounds[b];
        bounds = {Vec3f::Constant(3e38f), Vec3f::Constant(-3e38f)};
        for (int lane = 0; lane < kFloatLanes; ++lane) {
            const std::size_t k = b * kFloatLanes + lane;
            if (k < order.size())
                set_lane(packed.storage[b], lane, cloud, order[k].surfel, layer[order[k].surfel], bounds);
            else
                clear_lane(packed.storage[b], lane);
        }
        packed.summary[b] =
            summarise(packed.storage[b], int(std::min<std::size_t>(kFloatLanes, order.size() - b * kFloatLanes)));
    });
    return packed;
}

}  // namespace thixo::render
