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

/// Candidates prepared along the ray: x = reference + tau d, everything relative to the reference.
struct Patch {
    struct Lanes {
        __m256 qa, qb, qc;  // 1 - |M (x - s)|^2 = (qa tau + qb) tau + qc; never positive in lanes that take no part
        __m256 s[3], n[3], sn, ss;
    };
    Lanes lanes[kMaxRows];
    const Row* row[kMaxRows];
    unsigned taking_part[kMaxRows];
    int count = 0;
    int surfels = 0;
    float radius = 0;  // mean of sqrt(|t1||t2|)
    std::uint32_t layer = 0;

    __m256 weights(int i, __m256 tau) const {
        const Lanes& l = lanes[i];
        const __m256 q =
            _mm256_max_ps(_mm256_fmadd_ps(_mm256_fmadd_ps(l.qa, tau, l.qb), tau, l.qc), _mm256_setzero_ps());
        return _mm256_mul_ps(_mm256_mul_ps(q, q), q);
    }
    Fit fit(const Vec3f& d, float tau) const {
        FitSums sums;
        for (int i = 0; i < count; ++i) {
            const Lanes& l = lanes[i];
            const __m256 w = weights(i, _mm256_set1_ps(tau));
            sums.w = _mm256_add_ps(sums.w, w);
            sums.sn = _mm256_fmadd_ps(w, l.sn, sums.sn);
            sums.ss = _mm256_fmadd_ps(w, l.ss, sums.ss);
            for (int k = 0; k < 3; ++k) {
                sums.s[k] = _mm256_fmadd_ps(w, l.s[k], sums.s[k]);
                sums.n[k] = _mm256_fmadd_ps(w, l.n[k], sums.n[k]);
            }
        }
        return sums.fit(d, tau, radius);
    }
};

unsigned from(__m256 values, float limit) { return bits(_mm256_cmp_ps(values, _mm256_set1_ps(limit), _CMP_GE_OQ)); }
unsigned up_to(__m256 values, float limit) { return bits(_mm256_cmp_ps(values, _mm256_set1_ps(limit), _CMP_LE_OQ)); }

/// Lanes that look at a ray on this side, and those that look away from it.
unsigned facing(const Row& row, bool inside) {
    return inside ? from(row.facing, kFacing) : up_to(row.facing, -kFacing);
}
unsigned averted(const Row& row, bool inside) { return inside ? up_to(row.facing, 0) : from(row.facing, 0); }

/// Candidates that begin before `end`, less what the ray has left behind: surfels that look away from it (it has
/// bounced off them, it may be) and end before any that faces it begins weigh nothing where those do. False: some of
/// the others do not face the ray, or none is left.
bool choose_lanes(const Candidates& candidates, bool inside, float end, unsigned* lanes) {
    unsigned all = 0, rest = 0;
    for (int i = 0; i < candidates.row_count; ++i) {
        const Row& row = candidates.rows[i];
        lanes[i] = row.lanes & up_to(row.enter, end);
        rest |= lanes[i] & ~facing(row, inside);
        all |= lanes[i];
    }
    if (rest == 0) return all != 0;
    float begin = kInfinity;
    for (int i = 0; i < candidates.row_count; ++i)
        begin = std::min(begin, least(candidates.rows[i].enter, lanes[i] & facing(candidates.rows[i], inside)));
    for (int i = 0; i < candidates.row_count; ++i) {
        const Row& row = candidates.rows[i];
        lanes[i] &= ~(averted(row, inside) & ~from(row.leave, begin));
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
        const auto* layers = reinterpret_cast<const __m256i*>(blocks[patch.row[i]->block].layer);
        const __m256i same = _mm256_cmpeq_epi32(_mm256_load_si256(layers), _mm256_set1_epi32(int(patch.layer)));
        if ((patch.taking_part[i] & ~bits(_mm256_castsi256_ps(same))) != 0) return false;
    }
    return true;
}

/// False: their normals do not agree.
bool prepare(std::span<const SurfelBlock> blocks, const Vec3f& reference, float t_reference, Patch& patch) {
    __m256 normal[3] = {_mm256_setzero_ps(), _mm256_setzero_ps(), _mm256_setzero_ps()}, heights = normal[0];
    for (int i = 0; i < patch.count; ++i) {
        const Row& row = *patch.row[i];
        const SurfelBlock& block = blocks[row.block];
        const __m256 mask = mask_of(patch.taking_part[i]), height = _mm256_load_ps(block.height);
        Patch::Lanes& l = patch.lanes[i];
        const __m256 off = _mm256_sub_ps(_mm256_set1_ps(t_reference), row.near), two_b = _mm256_add_ps(row.b, row.b);
        const __m256 a_off = _mm256_mul_ps(row.a, off);
        l.qa = _mm256_and_ps(mask, _mm256_sub_ps(_mm256_setzero_ps(), row.a));
        l.qb = _mm256_and_ps(mask, _mm256_sub_ps(two_b, _mm256_add_ps(a_off, a_off)));
        l.qc = _mm256_blendv_ps(_mm256_set1_ps(-1.0f), _mm256_fmsub_ps(_mm256_sub_ps(two_b, a_off), off, row.c), mask);
        l.sn = l.ss = _mm256_setzero_ps();
        for (int k = 0; k < 3; ++k) {
            l.s[k] = _mm256_sub_ps(_mm256_load_ps(block.centre[k]), _mm256_set1_ps(reference[k]));
            l.n[k] = _mm256_mul_ps(_mm256_load_ps(block.to_unit[2][k]), height);
            l.sn = _mm256_fmadd_ps(l.s[k], l.n[k], l.sn);
            l.ss = _mm256_fmadd_ps(l.s[k], l.s[k], l.ss);
            normal[k] = _mm256_add_ps(normal[k], _mm256_and_ps(mask, l.n[k]));
        }
        heights = _mm256_add_ps(heights, _mm256_and_ps(mask, height));
        patch.surfels += std::popcount(patch.taking_part[i]);
    }
    patch.radius = sum(heights) / (kHeight * float(patch.surfels));
    const Vec3f mean = Vec3f(sum(normal[0]), sum(normal[1]), sum(normal[2])).normalized() / kNearMean;
    for (int i = 0; i < patch.count; ++i) {
        const Patch::Lanes& l = patch.lanes[i];
        const __m256 cosine = _mm256_fmadd_ps(
            l.n[0], _mm256_set1_ps(mean.x()),
            _mm256_fmadd_ps(l.n[1], _mm256_set1_ps(mean.y()), _mm256_mul_ps(l.n[2], _mm256_set1_ps(mean.z()))));
        if ((patch.taking_part[i] & ~bits(_mm256_cmp_ps(cosine, _mm256_set1_ps(1.0f), _CMP_GE_OQ))) != 0) return false;
    }
    return true;
}

/// Where the ray meets the discs' planes, by their weights there; NaN where all of these are zero.
float guess(const Patch& patch, float t_reference) {
    __m256 total = _mm256_setzero_ps(), product = total;
    for (int i = 0; i < patch.count; ++i) {
        // A lane that takes no part may be NaN; its weight is zero.
        const __m256 tau = _mm256_and_ps(mask_of(patch.taking_part[i]),
                                         _mm256_sub_ps(patch.row[i]->plane, _mm256_set1_ps(t_reference)));
        const __m256 w = patch.weights(i, tau);
        total = _mm256_add_ps(total, w);
        product = _mm256_fmadd_ps(w, tau, product);
    }
    return sum(product) / sum(total);
}

/// False: none weighs anything there.
bool note_weights(const Patch& patch, std::span<const SurfelBlock> blocks, float tau, SurfelHit& hit) {
    hit.count = 0;
    float total = 0;
    for (int i = 0; i < patch.count; ++i) {
        alignas(32) float w[kLanes];
        _mm256_store_ps(w, patch.weights(i, _mm256_set1_ps(tau)));
        for (unsigned lanes = patch.taking_part[i]; lanes != 0; lanes &= lanes - 1) {
            const int lane = std::countr_zero(lanes);
            if (w[lane] <= 0) continue;
            hit.source[hit.count] = blocks[patch.row[i]->block].source[lane];
            hit.weight[hit.count++] = w[lane];
            total += w[lane];
        }
    }
    for (int k = 0; k < hit.count; ++k) hit.weight[k] /= total;
    return hit.count > 0;
}

}  // namespace

bool smooth_crossing(std::span<const SurfelBlock> blocks, const Ray& ray, const Interior& interior,
                     std::span<const Index> object, const Trims& trims, const Candidates& candidates, float end,
                     bool want_weights, SurfelHit& hit) {
    if (candidates.row_count == 0) return false;
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
    if (!prepare(blocks, ray.origin + t_reference * d, t_reference, patch)) return false;
    // Where Newton's last step was shorter than this, its own error is under 1e-5 radii.
    const float last_step = kLastStep * patch.radius, reach = 16 * patch.radius;
    float tau = guess(patch, t_reference);
    for (int i = 0; i < 6; ++i) {
        if (!(std::abs(tau) < reach)) return false;
        const Fit at = patch.fit(d, tau);
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
            !trims.keeps(object[patch.layer], patch.layer, ray.origin + t * d, patch.radius))
            return false;
        hit.t = t;
        hit.normal = (at.gradient + step * at.curvature * d).normalized();
        hit.radius = patch.radius;
        hit.layer = patch.layer;
        return !want_weights || note_weights(patch, blocks, tau + step, hit);
    }
    return false;
}

}  // namespace thixo::render
