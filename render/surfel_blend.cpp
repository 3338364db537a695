#include "render/surfel_blend.h"

#include <algorithm>
#include <array>

#include "render/surfel_fit.h"
#include "render/surfel_patch.h"

namespace thixo::render {
namespace {

constexpr int kCapacity = Candidates::kCapacity;

/// Where on the ray tau is zero.
struct Reference {
    Vec3f position;   // [m]
    Vec3f direction;  // of the ray, unit
    float t;          // [m]
};

/// Candidates that blend into one surface, prepared along the ray.
struct Group {
    FitLanes lanes[kCapacity / kFloatLanes];
    IndexLanes source[kCapacity / kFloatLanes];
    float enter[kCapacity];  // tau at which a surfel's support begins
    int count = 0;
    float start = 0, end = 0;     // tau, the union of the supports
    float radius = 0;             // mean of sqrt(|t1||t2|) [m]
    float away = 0, towards = 0;  // largest and smallest n.d
    std::uint32_t layer = 0;
    Index object = 0;

    std::span<const FitLanes> prepared() const { return {lanes, std::size_t((count + kFloatLanes - 1) / kFloatLanes)}; }
};

/// Surfaces one window can hold; of more, which takes a heap of crossed discs, the weakest are left out.
constexpr int kMaxGroups = 12;

Fit fit(const Group& g, const Vec3f& d, float tau) { return fit(g.prepared(), d, tau, g.radius); }

Vec3f normal_of(const SurfelBlock& block, int lane) {
    const float h = block.height[lane];
    return {block.to_unit[2][0][lane] * h, block.to_unit[2][1][lane] * h, block.to_unit[2][2][lane] * h};
}
Vec3f centre_of(const SurfelBlock& block, int lane) {
    return {block.centre[0][lane], block.centre[1][lane], block.centre[2][lane]};
}

void append(Group& g, const Gathering& from, const Reference& reference, const Candidate& candidate,
            const Vec3f& normal, float agreement) {
    SurfelBlock room;
    const SurfelBlock& block = from.packed.at(candidate.surfel / kFloatLanes, from.ray.time, room);
    const int i = g.count++, lane = candidate.surfel % kFloatLanes, at = i % kFloatLanes;
    FitLanes& l = g.lanes[i / kFloatLanes];
    const Vec3f &d = reference.direction, s = centre_of(block, lane) - reference.position;
    float a = 0, b = 0, c = 0;
    for (int row = 0; row < 3; ++row) {
        const Vec3f m(block.to_unit[row][0][lane], block.to_unit[row][1][lane], block.to_unit[row][2][lane]);
        const float p = m.dot(s), e = m.dot(d);
        a += e * e;
        b += e * p;
        c += p * p;
    }
    l.qa[at] = -a;
    l.qb[at] = 2 * b;
    l.qc[at] = 1 - c;
    for (int k = 0; k < 3; ++k) {
        l.s[k][at] = s[k];
        l.n[k][at] = normal[k];
    }
    l.sn[at] = s.dot(normal);
    l.ss[at] = s.squaredNorm();
    l.agreement[at] = agreement;
    g.source[i / kFloatLanes][at] = block.source[lane];
    g.enter[i] = candidate.enter - reference.t;
    g.start = std::min(g.start, g.enter[i]);
    g.end = std::max(g.end, candidate.leave - reference.t);
    g.radius += block.height[lane];
    g.away = std::max(g.away, normal.dot(d));
    g.towards = std::min(g.towards, normal.dot(d));
}

void pad(Group& g) {
    g.radius /= kHeight * float(g.count);
    for (int i = g.count; i % kFloatLanes != 0; ++i) {
        FitLanes& l = g.lanes[i / kFloatLanes];
        const int at = i % kFloatLanes;
        l.qa[at] = l.qb[at] = l.agreement[at] = l.sn[at] = l.ss[at] = 0;
        l.qc[at] = -1;
        for (int k = 0; k < 3; ++k) l.s[k][at] = l.n[k][at] = 0;
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

/// True where a crossing of one surface lies beyond the edge it makes with another of the same object. It is then in
/// front of that other surface, and the surfels that carry the crossing are behind it. (Across a narrow gap both are in
/// front.) Edges come out sharp. They are closed, since each side may stand out by kOverlap radii. The two differ by
/// less than that where they are parts of one smooth surface.
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
/// away. It would be caught there. A crossing within this many radii that the normal contradicts is none.
constexpr float kStart = 0.3f;  // radii

/// Where the next support begins, at t or behind it.
float next_support(const Group& g, float t) {
    float next = kInfinity;
    for (int i = 0; i < g.count; ++i)
        if (g.enter[i] >= t) next = std::min(next, g.enter[i]);
    return next;
}

/// What the groups of one window lie along.
struct Window {
    const Gathering& from;
    const Trims& trims;
    std::span<const Group> groups;
    Reference reference;
    float end = 0;  // tau
};
struct Crossing {
    float tau = 0;
    Fit at;
};

/// Walks along the ray from tau = start by the distance f tells, until f changes to the sign of the other side.
bool crossing_of(const Window& window, const Group& g, float start, bool inside, Crossing& found) {
    const Ray& ray = window.from.ray;
    const Vec3f& d = ray.direction;
    const float begin = std::max(start, g.start);
    const bool trimmed = window.trims.trimmed(g.object);
    const float end = std::min(window.end, g.end);
    const float sign = inside ? -1.0f : 1.0f;
    const float step_min = 0.12f * g.radius, step_max = 0.6f * g.radius;
    float& tau = found.tau;
    Fit& at = found.at;
    float t = begin, t_before = 0, f_before = -1;  // f_before > 0: on the near side
    while (begin <= end) {
        const Fit here = fit(g, d, t);
        const float f = sign * here.distance;
        if (here.weight > 0 && f <= 0 && f_before > 0) {
            tau = refine(g, d, t_before, f_before * sign, t, f * sign, at);
            const bool against = ray.bounced && tau - start < kStart * g.radius && sign * at.gradient.dot(d) > 0;
            if (at.weight > 0 && !against && !beyond_edge(window.groups, g, trimmed, d, tau, at) &&
                (!trimmed || window.trims.keeps(g.object, g.layer, ray.origin + (window.reference.t + tau) * d,
                                                g.radius, window.from.seconds())))
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

float peak_weight(const SurfelBlock& block, const Ray& ray, const Candidate& c, float end) {
    const int lane = c.surfel % kFloatLanes;
    const float t = std::clamp(0.5f * (c.enter + c.leave), ray.tmin, end);
    const Vec3f y = centre_of(block, lane) - (ray.origin + t * ray.direction);
    float r2 = 0;
    for (int row = 0; row < 3; ++row)
        r2 += square(block.to_unit[row][0][lane] * y.x() + block.to_unit[row][1][lane] * y.y() +
                     block.to_unit[row][2][lane] * y.z());
    return cube(std::max(1 - r2, 1e-4f));
}

/// The open candidates that agree with the strongest of them.
void next_group(const Gathering& from, const Candidates& candidates, const Reference& reference, int seed, Work& work,
                Group& g) {
    Vec3f mean = Vec3f::Zero();
    for (int i = 0; i < candidates.count; ++i)
        if (work.open[i] && work.layer[i] == work.layer[seed] && work.normal[i].dot(work.normal[seed]) > 0.5f)
            mean += work.peak[i] * work.normal[i];
    mean.normalize();
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
        append(g, from, reference, c, work.normal[i], std::max(a * a * (3 - 2 * a), 1e-6f));
        work.open[i] = false;
    }
    pad(g);
}

/// Keeps the candidates that begin before `end`, in the order of the surfels and not of the traversal: sums must not
/// depend on it.
void sort_candidates(Candidates& candidates, float end) {
    int kept = 0;
    for (int i = 0; i < candidates.count; ++i)
        if (candidates.list[i].enter <= end) candidates.list[kept++] = candidates.list[i];
    candidates.count = kept;
    std::sort(candidates.list, candidates.list + kept,
              [](const Candidate& a, const Candidate& b) { return a.surfel < b.surfel; });
}

/// Looks at every candidate once; returns where on the ray the first of them begins, but not before the window [m].
float look_at(const Gathering& from, const Candidates& candidates, float end, Work& work) {
    float first = kInfinity;
    for (int i = 0; i < candidates.count; ++i) {
        const Candidate& c = candidates.list[i];
        SurfelBlock room;
        const SurfelBlock& block = from.packed.at(c.surfel / kFloatLanes, from.ray.time, room);
        const int lane = c.surfel % kFloatLanes;
        work.layer[i] = block.layer[lane];
        work.normal[i] = normal_of(block, lane);
        work.peak[i] = peak_weight(block, from.ray, c, end);
        work.open[i] = true;
        first = std::min(first, c.enter);
    }
    return std::max(first, from.ray.tmin);
}

}  // namespace

bool first_crossing(const Gathering& from, const Trims& trims, Candidates& candidates, float end, bool want_sources,
                    SurfelHit& hit) {
    if (!candidates.listed && smooth_crossing(from, trims, candidates, end, want_sources, hit)) return true;
    const Ray& ray = from.ray;
    candidates.make_list(ray.tmin);
    sort_candidates(candidates, end);
    if (candidates.count == 0) return false;
    Work work;
    const float t_reference = look_at(from, candidates, end, work);
    const Reference reference{ray.origin + t_reference * ray.direction, ray.direction, t_reference};

    std::array<Group, kMaxGroups> store;
    int count = 0;
    for (; count < kMaxGroups; ++count) {
        int seed = -1;
        for (int i = 0; i < candidates.count; ++i)
            if (work.open[i] && (seed < 0 || work.peak[i] > work.peak[seed])) seed = i;
        if (seed < 0) break;
        Group& g = store[std::size_t(count)];
        next_group(from, candidates, reference, seed, work, g);
        g.object = from.object[work.layer[seed]];
    }
    const Window window{from, trims, {store.data(), std::size_t(count)}, reference, end - t_reference};

    bool found = false;
    for (const Group& g : window.groups) {
        const bool inside = from.interior.count() > 0 && from.interior.contains(g.object);
        if (inside ? g.away < 0 : g.towards > 0) continue;  // f only moves away from the crossing looked for
        Crossing crossing;
        if (!crossing_of(window, g, candidates.start(ray, g.radius) - t_reference, inside, crossing)) continue;
        if (found && t_reference + crossing.tau >= hit.t) continue;
        found = true;
        hit.t = t_reference + crossing.tau;
        hit.normal = crossing.at.gradient.normalized();
        hit.radius = g.radius;
        hit.layer = g.layer;
        const auto source = [&](std::size_t row) -> const IndexLanes& { return g.source[row]; };
        if (want_sources) note_sources(g.prepared(), crossing.tau, source, hit);
    }
    return found;
}

}  // namespace thixo::render
