// Directional albedos of rough lobes, and the lobe that gives back what they lose.
#pragma once

#include <array>

#include "render/materials/microfacet.h"

namespace thixo::render {

/// Directional albedo E(mu) of a lobe at 32 even steps of mu = cos, and its mean
///   2 int E mu dmu   over [0, 1].
struct AlbedoTable {
    static constexpr int kSteps = 32;
    std::array<float, kSteps + 1> at{};
    float mean = 0;
    float operator()(float mu) const {
        const float x = std::clamp(mu, 0.0f, 1.0f) * kSteps;
        const int i = std::min(int(x), kSteps - 1);
        return at[i] + (x - float(i)) * (at[i + 1] - at[i]);
    }
};

/// Fills in the mean of the piecewise linear E.
void add_mean(AlbedoTable& table);

/// Point i of n of a rank-1 lattice (golden ratio).
Vec2f lattice(int i, int n);

/// E(mu) of rough facets that reflect reflectance(cosine at the facet): the mean of
///   F G2 / G1
/// over reflections at visible normals.
template <class Reflectance>
AlbedoTable tabulate_reflection(float alpha, Reflectance&& reflectance) {
    constexpr int samples = 1024;
    AlbedoTable table;
    for (int k = 0; k <= AlbedoTable::kSteps; ++k) {
        const float mu = std::max(float(k) / AlbedoTable::kSteps, 1e-3f);
        const Vec3f wo(std::sqrt(1 - mu * mu), 0, mu);
        double sum = 0;
        for (int i = 0; i < samples; ++i) {
            const Vec3f h = sample_visible_normal(wo, alpha, lattice(i, samples));
            const Vec3f wi = 2 * wo.dot(h) * h - wo;
            if (wi.z() > 0) sum += double(reflectance(wo.dot(h)) * ggx_g2(wo, wi, alpha) / ggx_g1(wo, alpha));
        }
        table.at[k] = float(sum / samples);
    }
    add_mean(table);
    return table;
}

/// The diffuse-like lobe that takes up what a reflecting lobe of albedo E leaves, times cos(wi) (Kelemen &
/// Szirmay-Kalos 2001):
///   (1 - E(wo)) (1 - E(wi)) / (pi (1 - E mean)) cos(wi)   [1/sr]
/// Its own albedo is 1 - E(wo).
inline float remaining_lobe(const AlbedoTable& albedo, const Vec3f& wo, const Vec3f& wi) {
    const float lost = std::max(1 - albedo.mean, 1e-6f);
    return (1 - albedo(wo.z())) * (1 - albedo(wi.z())) / lost * wi.z() / kPif;
}

}  // namespace thixo::render
