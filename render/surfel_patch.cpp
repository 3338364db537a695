#include "render/surfel_patch.h"

#include <bit>
#include <cmath>

#include "render/surfel_fit.h"

namespace thixo::render {
namespace {

constexpr int kMaxRows = Candidates::kRows;
/// Normals this near to their mean are within 35 degrees of each other: they agree fully with any mean of them.
constexpr float kNearMean = 0.95371695f;  // 17.5 degrees
constexpr float kFacing = 0.1f;
constexpr float kLastStep = 3e-3f;  // radii

/// Candidates prepared along the ray, row by row.
struct Patch {
    FitLanes lanes[kMaxRows];
    const Row* row[kMaxRows];
    unsigned taking_part[kMaxRows];
    int count = 0;
    int surfels = 0;
    float radius = 0;  // mean of sqrt(|t1||t2|) [m]
    std::uint32_t layer = 0;

    std::span<const FitLanes> prepared() const { return {lanes, std::size_t(count)}; }
};

unsigned at_least(FloatLanes values, float limit) { return bits(values >= limit); }
unsigned at_most(FloatLanes values, float limit) { return bits(values <= limit); }

/// Lanes that look at a ray on this side, and those that look away from it.
unsigned facing(const Row& row, bool inside) {
    return inside ? at_least(row.facing, kFacing) : at_most(row.facing, -kFacing);
}
unsigned averted(const Row& row, bool inside) { return inside ? at_most(row.facing, 0) : at_least(row.facing, 0); }

/// Candidates that begin before `end`, less what the ray has left behind. Left behind are surfels that look away from
/// the ray and end before any that faces it begins: they weigh nothing there. False: some of the others do not face the
/// ray, or none is left.
bool choose_lanes(const Candidates& candidates, bool inside, float end, unsigned* lanes) {
    unsigned all = 0, rest = 0;
    for (int i = 0; i < candidates.row_count; ++i) {
        const Row& row = candidates.rows[i];
        lanes[i] = row.lanes & at_most(row.enter, end);
        rest |= lanes[i] & ~facing(row, inside);
        all |= lanes[i];
    }
    if (rest == 0) return all != 0;
    float begin = kInfinity;
    for (int i = 0; i < candidates.row_count; ++i)
        begin = std::min(begin, least(candidates.rows[i].enter, lanes[i] & facing(candidates.rows[i], inside)));
    for (int i = 0; i < candidates.row_count; ++i) {
        const Row& row = candidates.rows[i];
        lanes[i] &= ~(averted(row, inside) & ~at_least(row.leave, begin));
        if ((lanes[i] & ~facing(row, inside)) != 0) return false;
    }
    return begin < kInfinity;
}

/// Rows by block: sums must not depend on the traversal. False: of several layers.
bool sort_rows(std::span<const SurfelBlock> blocks, const Candidates& candidates, const unsigned* chosen,
               Patch& patch) {
    for (int i = 0; i < candidates.row_count; ++i) {
        const Row& row = candidates.rows[i];
        const unsigned lanes = chosen[i];
        if (lanes == 0) continue;
        int at = patch.count++;
        for (; at > 0 && patch.row[at - 1]->block > row.block; --at) {
            patch.row[at] = patch.row[at - 1];
            patch.taking_part[at] = patch.taking_part[at - 1];
        }
        patch.row[at] = &row;
        patch.taking_part[at] = lanes;
    }
    if (patch.count == 0) return false;
    patch.layer = blocks[patch.row[0]->block].layer[std::countr_zero(patch.taking_part[0])];
    for (int i = 0; i < patch.count; ++i) {
        if ((patch.taking_part[i] & ~bits(blocks[patch.row[i]->block].layer == patch.layer)) != 0) return false;
    }
    return true;
}

/// False: their normals do not agree.
bool prepare(const SurfelBlocks& packed, float time, const Vec3f& reference, float t_reference, Patch& patch) {
    FloatLanes normal[3]{}, heights{};
    for (int i = 0; i < patch.count; ++i) {
        const Row& row = *patch.row[i];
        SurfelBlock room;
        const SurfelBlock& block = packed.at(row.block, time, room);
        const LaneMask mask = mask_of(patch.taking_part[i]);
        FitLanes& l = patch.lanes[i];
        const FloatLanes off = t_reference - row.near, two_b = row.b + row.b, a_off = row.a * off;
        l.qa = mask ? 0.0f - row.a : FloatLanes{};
        l.qb = mask ? two_b - (a_off + a_off) : FloatLanes{};
        l.qc = mask ? multiply_subtract(two_b - a_off, off, row.c) : float_lanes(-1);
        l.agreement = float_lanes(1);
        l.sn = l.ss = FloatLanes{};
        for (int k = 0; k < 3; ++k) {
            l.s[k] = block.centre[k] - float_lanes(reference[k]);
            l.n[k] = block.to_unit[2][k] * block.height;
            l.sn = multiply_add(l.s[k], l.n[k], l.sn);
            l.ss = multiply_add(l.s[k], l.s[k], l.ss);
            normal[k] += mask ? l.n[k] : FloatLanes{};
        }
        heights += mask ? block.height : FloatLanes{};
        patch.surfels += std::popcount(patch.taking_part[i]);
    }
    patch.radius = packed_sum(heights) / (kHeight * float(patch.surfels));
    const Vec3f mean =
        Vec3f(packed_sum(normal[0]), packed_sum(normal[1]), packed_sum(normal[2])).normalized() / kNearMean;
    for (int i = 0; i < patch.count; ++i) {
        const FloatLanes(&n)[3] = patch.lanes[i].n;
        const FloatLanes cosine = multiply_add(n[0], float_lanes(mean.x()),
                                               multiply_add(n[1], float_lanes(mean.y()), n[2] * float_lanes(mean.z())));
        if ((patch.taking_part[i] & ~bits(cosine >= 1.0f)) != 0) return false;
    }
    return true;
}

/// Where the ray meets the discs' planes, by their weights there; NaN where all of these are zero.
float guess(const Patch& patch, float t_reference) {
    FloatLanes total{}, product{};
    for (int i = 0; i < patch.count; ++i) {
        // A lane that takes no part may be NaN; its weight is zero.
        const FloatLanes tau = mask_of(patch.taking_part[i]) ? patch.row[i]->plane - t_reference : FloatLanes{};
        const FloatLanes w = weights(patch.lanes[i], tau);
        total += w;
        product = multiply_add(w, tau, product);
    }
    return packed_sum(product) / packed_sum(total);
}

}  // namespace

bool smooth_crossing(const Gathering& from, const Trims& trims, const Candidates& candidates, float end,
                     bool want_sources, SurfelHit& hit) {
    if (candidates.row_count == 0) return false;
    const std::span<const SurfelBlock> blocks = from.packed.blocks();
    const std::span<const Index> object = from.object;
    const Interior& interior = from.interior;
    const Ray& ray = from.ray;
    const Row& first = candidates.rows[0];
    const bool inside =
        interior.count() > 0 && interior.contains(object[blocks[first.block].layer[std::countr_zero(first.lanes)]]);
    unsigned lanes[Candidates::kRows];
    Patch patch;
    if (!choose_lanes(candidates, inside, end, lanes) || !sort_rows(blocks, candidates, lanes, patch)) return false;
    if (interior.count() > 0 && interior.contains(object[patch.layer]) != inside) return false;
    // Half-way through the first support: near the surface, and the same for every order of the rows.
    const float t_reference = std::max(ray.tmin, patch.row[0]->near[std::countr_zero(patch.taking_part[0])]);
    const Vec3f& d = ray.direction;
    if (!prepare(from.packed, ray.time, ray.origin + t_reference * d, t_reference, patch)) return false;
    // Where Newton's last step was shorter than this, its own error is under 1e-5 radii.
    const float last_step = kLastStep * patch.radius, reach = 16 * patch.radius;
    float tau = guess(patch, t_reference);
    for (int i = 0; i < 6; ++i) {
        if (!(std::abs(tau) < reach)) return false;
        const Fit at = fit(patch.prepared(), d, tau, patch.radius);
        const float slope = at.gradient.dot(d);
        if (!(at.weight > 0) || (inside ? slope < 0.5f * kFacing : slope > -0.5f * kFacing)) return false;
        const float step = -at.distance / slope;
        if (std::abs(step) >= last_step) {
            tau += step;
            continue;
        }
        const float t = t_reference + tau + step;
        if (!(t >= candidates.start(ray, patch.radius) && t <= end)) return false;
        if (trims.trimmed(object[patch.layer]) &&
            !trims.keeps(object[patch.layer], patch.layer, ray.origin + t * d, patch.radius, from.seconds()))
            return false;
        hit.t = t;
        hit.normal = (at.gradient + step * at.curvature * d).normalized();
        hit.radius = patch.radius;
        hit.layer = patch.layer;
        const auto source = [&](std::size_t row) -> const IndexLanes& { return blocks[patch.row[row]->block].source; };
        return !want_sources || note_sources(patch.prepared(), tau + step, source, hit);
    }
    return false;
}

}  // namespace thixo::render
