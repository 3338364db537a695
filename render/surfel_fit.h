// The algebraic sphere that weighted points and normals fit (Guennebaud & Gross 2007, beta = 1).
#pragma once

#include <algorithm>

#include "pipeline/base/math.h"
#include "render/lanes.h"

namespace thixo::render {

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
    __m256 w = _mm256_setzero_ps();
    __m256 s[3] = {w, w, w}, n[3] = {w, w, w};
    __m256 sn = w, ss = w;

    /// The sphere seen from x = tau d, places being relative to tau = 0. Its curvature is at most one over `radius`.
    Fit fit(const Vec3f& d, float tau, float radius) const {
        Fit result;
        result.weight = sum(w);
        if (!(result.weight > 1e-12f)) return {};
        // Eight sums at once: pairs are added three times over.
        const __m256 a = _mm256_hadd_ps(_mm256_hadd_ps(s[0], s[1]), _mm256_hadd_ps(s[2], n[0])),
                     b = _mm256_hadd_ps(_mm256_hadd_ps(n[1], n[2]), _mm256_hadd_ps(sn, ss));
        const __m256 total = _mm256_add_ps(_mm256_permute2f128_ps(a, b, 0x20), _mm256_permute2f128_ps(a, b, 0x31));
        alignas(32) float mean[8];
        _mm256_store_ps(mean, _mm256_mul_ps(total, _mm256_set1_ps(1 / result.weight)));
        const Vec3f place(mean[0], mean[1], mean[2]), normal(mean[3], mean[4], mean[5]);
        const Vec3f centre = place - tau * d;
        result.centre = centre;
        const float along = mean[6] - place.dot(normal);     // mean of y.n less mean y . mean n
        const float spread = mean[7] - place.squaredNorm();  // variance of y
        const float limit = 1.0f / radius;                   // of the curvature: a sphere of one surfel
        const float curvature = result.curvature =
            std::clamp(along / std::max(spread, 1e-3f * radius * radius), -limit, limit);
        result.gradient = normal - curvature * centre;
        result.distance = -(result.gradient.dot(centre) + 0.5f * curvature * (spread + centre.squaredNorm()));
        return result;
    }
};

}  // namespace thixo::render
