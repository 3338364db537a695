#include "render/surfel_patch.h"

#include <bit>
#include <cmath>

#include "render/surfel_fit.h"

namespace thixo::render {
namespace {

constexpr int kMaxRows = 6;
/// Normals this near to their mean are within 35 degrees of each other: they agree fully with any mean of them.
constexpr float kNearMean = 0.95371695f;  // 17.5 degrees
constexpr float kFacing = 0.2f;

unsigned bits(__m256 mask) { return unsigned(_mm256_movemask_ps(mask)); }

/// All bits set in the lanes of `lanes`.
__m256 mask_of(unsigned lanes) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(int(lanes)), bit), bit));
}

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
        const __m256 q = _mm256_max_ps(_mm256_fmadd_ps(_mm256_fmadd_ps(l.qa, tau, l.qb), tau, l.qc), _mm256_setzero_ps());
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

/// Rows with candidates that begin before `end`, by block: sums must not depend on the traversal. False: too many, none,
/// or of several layers.
bool choose_rows(std::span<const SurfelBlock> blocks, const Candidates& candidates, float end, Patch& patch) {
    for (int i = 0; i < candidates.row_count; ++i) {
        const Row& row = candidates.rows[i];
        const unsigned lanes = row.lanes & bits(_mm256_cmp_ps(row.enter, _mm256_set1_ps(end), _CMP_LE_OQ));
        if (lanes == 0) continue;
        if (patch.count == kMaxRows) return false;
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

/// All of them face a ray on this side.
bool all_face(const Patch& patch, bool inside) {
    for (int i = 0; i < patch.count; ++i) {
        const __m256 facing = patch.row[i]->facing;
        const unsigned good = bits(inside ? _mm256_cmp_ps(facing, _mm256_set1_ps(kFacing), _CMP_GE_OQ)
                                          : _mm256_cmp_ps(facing, _mm256_set1_ps(-kFacing), _CMP_LE_OQ));
        if ((patch.taking_part[i] & ~good) != 0) return false;
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
        const __m256 cosine =
            _mm256_fmadd_ps(l.n[0], _mm256_set1_ps(mean.x()),
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

void note_weights(const Patch& patch, std::span<const SurfelBlock> blocks, float tau, float total, SurfelHit& hit) {
    hit.count = 0;
    for (int i = 0; i < patch.count; ++i) {
        alignas(32) float w[kLanes];
        _mm256_store_ps(w, patch.weights(i, _mm256_set1_ps(tau)));
        for (unsigned lanes = patch.taking_part[i]; lanes != 0; lanes &= lanes - 1) {
            const int lane = std::countr_zero(lanes);
            if (w[lane] <= 0) continue;
            hit.source[hit.count] = blocks[patch.row[i]->block].source[lane];
            hit.weight[hit.count++] = w[lane] / total;
        }
    }
}

}  // namespace

bool smooth_crossing(std::span<const SurfelBlock> blocks, const Ray& ray, const Interior& interior,
                     std::span<const Index> object, const Trims& trims, const Candidates& candidates, float end,
                     bool want_weights, SurfelHit& hit) {
    Patch patch;
    if (!choose_rows(blocks, candidates, end, patch)) return false;
    const bool inside = interior.count() > 0 && interior.contains(object[patch.layer]);
    if (!all_face(patch, inside)) return false;
    // Half-way through the first support: near the surface, and the same for every order of the rows.
    const float t_reference = std::max(ray.tmin, patch.row[0]->near[std::countr_zero(patch.taking_part[0])]);
    const Vec3f& d = ray.direction;
    if (!prepare(blocks, ray.origin + t_reference * d, t_reference, patch)) return false;
    const float tolerance = 1e-5f * patch.radius, reach = 3 * patch.radius;
    float tau = guess(patch, t_reference);
    for (int i = 0; i < 6; ++i) {
        if (!(std::abs(tau) < reach)) return false;
        const Fit at = patch.fit(d, tau);
        const float slope = at.gradient.dot(d);
        if (!(at.weight > 0) || (inside ? slope < 0.5f * kFacing : slope > -0.5f * kFacing)) return false;
        if (std::abs(at.distance) >= tolerance) {
            tau -= at.distance / slope;
            continue;
        }
        const float t = t_reference + tau;
        if (!(t >= ray.tmin && t <= end)) return false;
        if (trims.trimmed(object[patch.layer]) &&
            !trims.keeps(object[patch.layer], patch.layer, ray.origin + t * d, patch.radius))
            return false;
        hit.t = t;
        hit.normal = at.gradient.normalized();
        hit.radius = patch.radius;
        hit.layer = patch.layer;
        if (want_weights) note_weights(patch, blocks, tau, at.weight, hit);
        return true;
    }
    return false;
}

}  // namespace thixo::render
