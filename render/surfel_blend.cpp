#include "render/surfel_blend.h"

#include <algorithm>
#include <array>

#include "render/surfel_fit.h"
#include "render/surfel_patch.h"

namespace thixo::render {
namespace {

constexpr int kCapacity = Candidates::kCapacity;

/// Candidates that blend into one surface, prepared along the ray: x = reference + tau d, everything relative to the
/// reference.
struct Group {
    alignas(32) float qa[kCapacity], qb[kCapacity], qc[kCapacity];  // 1 - |M (x - s)|^2 = (qa tau + qb) tau + qc
    alignas(32) float s[3][kCapacity], n[3][kCapacity], sn[kCapacity], ss[kCapacity];  // s.n, s.s
    alignas(32) float agreement[kCapacity];  // weight by angle to the mean normal
    float enter[kCapacity];                  // tau at which its support begins
    Index member[kCapacity];                 // index in the candidates
    int count = 0;
    float start = 0, end = 0;     // tau, the union of the supports
    float radius = 0;             // mean of sqrt(|t1||t2|)
    float away = 0, towards = 0;  // largest and smallest n.d
    std::uint32_t layer = 0;
    Index object = 0;
};

/// Surfaces one window can hold; of more, which takes a heap of crossed discs, the weakest are left out.
constexpr int kMaxGroups = 12;

__m256 weights(const Group& g, int i, __m256 tau) {
    const __m256 q = _mm256_fmadd_ps(_mm256_fmadd_ps(_mm256_load_ps(g.qa + i), tau, _mm256_load_ps(g.qb + i)), tau,
                                     _mm256_load_ps(g.qc + i));
    const __m256 positive = _mm256_max_ps(q, _mm256_setzero_ps());
    return _mm256_mul_ps(_mm256_mul_ps(positive, positive), _mm256_mul_ps(positive, _mm256_load_ps(g.agreement + i)));
}

Fit fit(const Group& g, const Vec3f& d, float tau_scalar) {
    const __m256 tau = _mm256_set1_ps(tau_scalar);
    FitSums sums;
    for (int i = 0; i < g.count; i += kLanes) {
        const __m256 w = weights(g, i, tau);
        sums.w = _mm256_add_ps(sums.w, w);
        sums.sn = _mm256_fmadd_ps(w, _mm256_load_ps(g.sn + i), sums.sn);
        sums.ss = _mm256_fmadd_ps(w, _mm256_load_ps(g.ss + i), sums.ss);
        for (int k = 0; k < 3; ++k) {
            sums.s[k] = _mm256_fmadd_ps(w, _mm256_load_ps(g.s[k] + i), sums.s[k]);
            sums.n[k] = _mm256_fmadd_ps(w, _mm256_load_ps(g.n[k] + i), sums.n[k]);
        }
    }
    return sums.fit(d, tau_scalar, g.radius);
}

Vec3f normal_of(const SurfelBlock& block, int lane) {
    const float h = block.height[lane];
    return {block.to_unit[2][0][lane] * h, block.to_unit[2][1][lane] * h, block.to_unit[2][2][lane] * h};
}

void append(Group& g, const SurfelBlock& block, int lane, const Vec3f& reference, const Vec3f& d, const Vec3f& normal,
            float agreement, const Candidate& candidate, float t_reference, Index member) {
    const int i = g.count++;
    const Vec3f s = Vec3f(block.centre[0][lane], block.centre[1][lane], block.centre[2][lane]) - reference;
    float a = 0, b = 0, c = 0;
    for (int row = 0; row < 3; ++row) {
        const Vec3f m(block.to_unit[row][0][lane], block.to_unit[row][1][lane], block.to_unit[row][2][lane]);
        const float p = m.dot(s), e = m.dot(d);
        a += e * e;
        b += e * p;
        c += p * p;
    }
    g.qa[i] = -a;
    g.qb[i] = 2 * b;
    g.qc[i] = 1 - c;
    for (int k = 0; k < 3; ++k) {
        g.s[k][i] = s[k];
        g.n[k][i] = normal[k];
    }
    g.sn[i] = s.dot(normal);
    g.ss[i] = s.squaredNorm();
    g.agreement[i] = agreement;
    g.member[i] = member;
    g.enter[i] = candidate.enter - t_reference;
    g.start = std::min(g.start, g.enter[i]);
    g.end = std::max(g.end, candidate.leave - t_reference);
    g.radius += block.height[lane];
    g.away = std::max(g.away, normal.dot(d));
    g.towards = std::min(g.towards, normal.dot(d));
}

void pad(Group& g) {
    g.radius /= kHeight * float(g.count);
    for (int i = g.count; i % kLanes != 0; ++i) {
        g.qa[i] = g.qb[i] = g.agreement[i] = g.sn[i] = g.ss[i] = 0;
        g.qc[i] = -1;
        for (int k = 0; k < 3; ++k) g.s[k][i] = g.n[k][i] = 0;
    }
}

/// Root of f between a (f of sign `sign_a`) and b, by the Illinois form of regula falsi.
float refine(const Group& g, const Vec3f& d, float a, float fa, float b, float fb, Fit& at) {
    const float tolerance = 1e-5f * g.radius;
    float t = b;
    int side = 0;
    for (int i = 0; i < 12; ++i) {
        t = a + (b - a) * (fa / (fa - fb));
        at = fit(g, d, t);
        if (std::abs(at.distance) < tolerance || b - a < tolerance) break;
        if ((at.distance > 0) == (fb > 0)) {
            b = t;
            fb = at.distance;
            if (side == 1) fa *= 0.5f;
            side = 1;
        } else {
            a = t;
            fa = at.distance;
            if (side == -1) fb *= 0.5f;
            side = -1;
        }
    }
    return t;
}

/// True where a crossing of one surface lies beyond the edge it makes with another of the same object: in front of that
/// other surface, with the surfels that carry the crossing behind it. (Across a narrow gap both are in front.) Edges
/// come out sharp; they are closed since each side may stand out by kOverlap radii, which is also more than the two
/// differ where they are parts of one smooth surface.
constexpr float kOverlap = 0.05f;
bool beyond_edge(std::span<const Group> groups, const Group& own, bool trimmed, const Vec3f& d, float tau,
                 const Fit& at) {
    for (const Group& other : groups) {
        if (&other == &own || other.object != own.object) continue;
        if (trimmed && other.layer != own.layer) continue;  // its tree decides between sheets
        const Fit there = fit(other, d, tau);
        if (there.weight > 0 && there.distance > kOverlap * other.radius &&
            there.distance + there.gradient.dot(at.centre) < 0)
            return true;
    }
    return false;
}

/// Right where a ray has bounced off uneven surfels, f may turn against it although the fitted normal says that it gets
/// away; it would then be caught there. A crossing within this many radii that the normal contradicts is none.
constexpr float kStart = 0.3f;  // radii

/// Where the next support begins, at t or behind it.
float next_support(const Group& g, float t) {
    float next = kInfinity;
    for (int i = 0; i < g.count; ++i)
        if (g.enter[i] >= t) next = std::min(next, g.enter[i]);
    return next;
}

/// Walks along the ray by the distance f tells, until f changes to the sign of the other side.
bool crossing_of(std::span<const Group> groups, const Group& g, const Trims& trims, const Ray& ray, float t_start,
                 float t_reference, float end, bool inside, float& tau, Fit& at) {
    const Vec3f& d = ray.direction;
    const float start = t_start - t_reference;
    const float begin = std::max(start, g.start);
    const bool trimmed = trims.trimmed(g.object);
    end = std::min(end, g.end);
    const float sign = inside ? -1.0f : 1.0f;
    const float step_min = 0.12f * g.radius, step_max = 0.6f * g.radius;
    float t = begin, t_before = 0, f_before = -1;  // f_before > 0: on the near side
    while (begin <= end) {
        const Fit here = fit(g, d, t);
        const float f = sign * here.distance;
        if (here.weight > 0 && f <= 0 && f_before > 0) {
            tau = refine(g, d, t_before, f_before * sign, t, f * sign, at);
            const bool against = ray.bounced && tau - start < kStart * g.radius && sign * at.gradient.dot(d) > 0;
            if (at.weight > 0 && !against && !beyond_edge(groups, g, trimmed, d, tau, at) &&
                (!trimmed || trims.keeps(g.object, g.layer, ray.origin + (t_reference + tau) * d, g.radius)))
                return true;
        }
        f_before = here.weight > 0 ? f : -1;
        t_before = t;
        if (t >= end) break;
        const float slope = std::max(std::abs(here.gradient.dot(d)), 0.2f);
        // Between supports there is nothing: on to the next, and a little into it.
        t = std::min(end, here.weight > 0 ? t + std::clamp(1.05f * std::abs(f) / slope, step_min, step_max)
                                          : std::max(t, next_support(g, t)) + step_min);
    }
    return false;
}

struct Work {
    std::uint32_t layer[kCapacity];
    Vec3f normal[kCapacity];
    float peak[kCapacity];  // largest weight along the window
    bool open[kCapacity];   // not in a group yet
};

float peak_weight(const SurfelBlock& block, int lane, const Ray& ray, const Candidate& c, float begin, float end) {
    const float t = std::clamp(0.5f * (c.enter + c.leave), begin, end);
    const Vec3f y =
        Vec3f(block.centre[0][lane], block.centre[1][lane], block.centre[2][lane]) - (ray.origin + t * ray.direction);
    float r2 = 0;
    for (int row = 0; row < 3; ++row)
        r2 += square(block.to_unit[row][0][lane] * y.x() + block.to_unit[row][1][lane] * y.y() +
                     block.to_unit[row][2][lane] * y.z());
    return cube(std::max(1 - r2, 1e-4f));
}

/// The open candidates that agree with the strongest of them.
void next_group(std::span<const SurfelBlock> blocks, const Ray& ray, const Candidates& candidates, Work& work, int seed,
                float t_reference, Group& g) {
    Vec3f mean = Vec3f::Zero();
    for (int i = 0; i < candidates.count; ++i)
        if (work.open[i] && work.layer[i] == work.layer[seed] && work.normal[i].dot(work.normal[seed]) > 0.5f)
            mean += work.peak[i] * work.normal[i];
    mean.normalize();
    const Vec3f reference = ray.origin + t_reference * ray.direction;
    g.count = 0;
    g.start = kInfinity;
    g.end = g.away = -kInfinity;
    g.towards = kInfinity;
    g.radius = 0;
    g.layer = work.layer[seed];
    for (int i = 0; i < candidates.count; ++i) {
        if (!work.open[i] || work.layer[i] != work.layer[seed]) continue;
        const float cosine = work.normal[i].dot(mean);
        if (cosine <= kLimitCosine && i != seed) continue;
        const float a = clamp01((cosine - kLimitCosine) / (kFullCosine - kLimitCosine));
        const Candidate& c = candidates.list[i];
        append(g, blocks[c.surfel / kLanes], c.surfel % kLanes, reference, ray.direction, work.normal[i],
               std::max(a * a * (3 - 2 * a), 1e-6f), c, t_reference, Index(i));
        work.open[i] = false;
    }
    pad(g);
}

void note_weights(const Group& g, std::span<const SurfelBlock> blocks, const Candidates& candidates, float tau,
                  SurfelHit& hit) {
    alignas(32) float w[kCapacity];
    float total = 0;
    for (int i = 0; i < g.count; i += kLanes) _mm256_store_ps(w + i, weights(g, i, _mm256_set1_ps(tau)));
    for (int i = 0; i < g.count; ++i) total += w[i];
    hit.count = 0;
    for (int i = 0; i < g.count; ++i) {
        if (w[i] <= 0) continue;
        const Index surfel = candidates.list[g.member[i]].surfel;
        hit.source[hit.count] = blocks[surfel / kLanes].source[surfel % kLanes];
        hit.weight[hit.count++] = w[i] / total;
    }
}

}  // namespace

bool first_crossing(std::span<const SurfelBlock> blocks, const Ray& ray, const Interior& interior,
                    std::span<const Index> object, const Trims& trims, Candidates& candidates, float end,
                    bool want_weights, SurfelHit& hit) {
    if (!candidates.listed && smooth_crossing(blocks, ray, interior, object, trims, candidates, end, want_weights, hit))
        return true;
    candidates.make_list(ray.tmin);
    // In the order of the surfels, not of the traversal: sums must not depend on it.
    int kept = 0;
    for (int i = 0; i < candidates.count; ++i)
        if (candidates.list[i].enter <= end) candidates.list[kept++] = candidates.list[i];
    candidates.count = kept;
    if (kept == 0) return false;
    std::sort(candidates.list, candidates.list + kept,
              [](const Candidate& a, const Candidate& b) { return a.surfel < b.surfel; });

    Work work;
    float t_reference = kInfinity;
    for (int i = 0; i < kept; ++i) {
        const Candidate& c = candidates.list[i];
        const SurfelBlock& block = blocks[c.surfel / kLanes];
        const int lane = c.surfel % kLanes;
        work.layer[i] = block.layer[lane];
        work.normal[i] = normal_of(block, lane);
        work.peak[i] = peak_weight(block, lane, ray, c, ray.tmin, end);
        work.open[i] = true;
        t_reference = std::min(t_reference, c.enter);
    }
    t_reference = std::max(t_reference, ray.tmin);

    std::array<Group, kMaxGroups> store;
    int count = 0;
    for (; count < kMaxGroups; ++count) {
        int seed = -1;
        for (int i = 0; i < kept; ++i)
            if (work.open[i] && (seed < 0 || work.peak[i] > work.peak[seed])) seed = i;
        if (seed < 0) break;
        next_group(blocks, ray, candidates, work, seed, t_reference, store[std::size_t(count)]);
        store[std::size_t(count)].object = object[work.layer[seed]];
    }
    const std::span<const Group> groups(store.data(), std::size_t(count));

    bool found = false;
    for (const Group& g : groups) {
        const bool inside = interior.count() > 0 && interior.contains(g.object);
        if (inside ? g.away < 0 : g.towards > 0) continue;  // f only moves away from the crossing looked for
        float tau = 0;
        Fit at;
        if (!crossing_of(groups, g, trims, ray, candidates.start(ray, g.radius), t_reference, end - t_reference, inside,
                         tau, at))
            continue;
        if (found && t_reference + tau >= hit.t) continue;
        found = true;
        hit.t = t_reference + tau;
        hit.normal = at.gradient.normalized();
        hit.radius = g.radius;
        hit.layer = g.layer;
        if (want_weights) note_weights(g, blocks, candidates, tau, hit);
    }
    return found;
}

}  // namespace thixo::render
