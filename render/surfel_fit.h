// The one fit that every surfel hit rests on. Surfels have weights at a point of a ray; an algebraic sphere fits the
// weighted places and normals (Guennebaud & Gross 2007, beta = 1).
#pragma once

#include <algorithm>
#include <bit>
#include <span>

#include "pipeline/base/lanes.h"
#include "render/surfel_hit.h"

namespace thixo::render {

/// Eight surfels prepared along a ray. Points are
///   x = reference + tau d        [m],
/// and places are relative to the reference. A lane that takes no part weighs nothing at any tau.
struct FitLanes {
    FloatLanes qa, qb, qc;  // 1 - |M (x - s)|^2 = (qa tau + qb) tau + qc
    FloatLanes s[3], n[3];  // place [m], unit normal
    FloatLanes sn, ss;      // s.n [m], s.s [m^2]
    FloatLanes agreement;   // factor of the weight, by the angle between the surfel's normal and their mean
};

/// Weights at tau:
///   w = agreement (1 - |M (x - s)|^2)^3   inside of the support, 0 outside.
inline FloatLanes weights(const FitLanes& l, FloatLanes tau) {
    const FloatLanes q = positive(multiply_add(multiply_add(l.qa, tau, l.qb), tau, l.qc));
    return (q * q) * (q * l.agreement);
}

/// The fit at one point x of a ray.
struct Fit {
    float weight = 0;    // sum of the weights; 0: no surfel's support holds the point
    float distance = 0;  // signed, about metres
    Vec3f gradient{0, 0, 0};
    float curvature = 0;    // of the sphere: its gradient changes by this times the way [1/m]
    Vec3f centre{0, 0, 0};  // mean of the surfels, seen from the point
};

/// Sums over surfels, eight at a time: of the weights w, and of w times s (place), n (normal), s.n and s.s.
struct FitSums {
    FloatLanes w{};
    FloatLanes s[3]{}, n[3]{}, sn{}, ss{};

    void add(const FitLanes& l, FloatLanes weight) {
        w += weight;
        sn = multiply_add(weight, l.sn, sn);
        ss = multiply_add(weight, l.ss, ss);
        for (int k = 0; k < 3; ++k) {
            s[k] = multiply_add(weight, l.s[k], s[k]);
            n[k] = multiply_add(weight, l.n[k], n[k]);
        }
    }

    /// The sphere seen from x = reference + tau d. Its curvature is at most one over `radius` [m].
    Fit fit(const Vec3f& d, float tau, float radius) const {
        Fit result;
        result.weight = packed_sum(w);
        if (!(result.weight > 1e-12f)) return {};
        alignas(32) float mean[kFloatLanes];
        store(sums_of_eight({s[0], s[1], s[2], n[0], n[1], n[2], sn, ss}) * float_lanes(1 / result.weight), mean);
        const Vec3f place(mean[0], mean[1], mean[2]), normal(mean[3], mean[4], mean[5]);
        const Vec3f centre = place - tau * d;
        result.centre = centre;
        const float along = mean[6] - place.dot(normal);     // mean of s.n less mean s . mean n
        const float spread = mean[7] - place.squaredNorm();  // variance of s
        const float limit = 1.0f / radius;                   // of the curvature: a sphere of one surfel
        const float curvature = result.curvature =
            std::clamp(along / std::max(spread, 1e-3f * radius * radius), -limit, limit);
        result.gradient = normal - curvature * centre;
        result.distance = -(result.gradient.dot(centre) + 0.5f * curvature * (spread + centre.squaredNorm()));
        return result;
    }
};

inline Fit fit(std::span<const FitLanes> surfels, const Vec3f& d, float tau, float radius) {
    FitSums sums;
    for (const FitLanes& l : surfels) sums.add(l, weights(l, float_lanes(tau)));
    return sums.fit(d, tau, radius);
}

/// Notes in the hit which surfels placed it, with their weights at tau. The weights then sum to one. source(i) gives
/// the surfels' indices in the cloud for the lanes of surfels[i]. False: none weighs anything there.
template <class Source>
bool note_sources(std::span<const FitLanes> surfels, float tau, Source&& source, SurfelHit& hit) {
    hit.count = 0;
    float total = 0;
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        const FloatLanes w = weights(surfels[i], float_lanes(tau));
        for (unsigned lanes = bits(w > 0); lanes != 0; lanes &= lanes - 1) {
            const int lane = std::countr_zero(lanes);
            hit.source[hit.count] = source(i)[lane];
            hit.weight[hit.count++] = w[lane];
            total += w[lane];
        }
    }
    for (int k = 0; k < hit.count; ++k) hit.weight[k] /= total;
    return hit.count > 0;
}

}  // namespace thixo::render
