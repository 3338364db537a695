#include "render/materials/plastic.h"

namespace thixo::render {
namespace {

AlbedoTable tabulate_smooth(float ior) {
    AlbedoTable table;
    for (int k = 0; k <= AlbedoTable::kSteps; ++k) table.at[k] = fresnel(float(k) / AlbedoTable::kSteps, ior);
    add_mean(table);
    return table;
}

}  // namespace

Plastic::Plastic(const scene::Appearance& a) : roughness_(float(a.roughness)), ior_(float(a.ior)) {
    coat_ = smooth() ? tabulate_smooth(ior_)
                     : tabulate_reflection(roughness_, [&](float cosine) { return fresnel(cosine, ior_); });
}

/// Chance of the coat's lobe; the rest goes to the base's.
float Plastic::coat_chance(const Vec3f& colour, const Vec3f& wo) const {
    const float e = coat_(wo.z());
    return std::clamp(e / std::max(e + (1 - e) * luminance(colour), 1e-6f), 0.1f, 0.9f);
}

Vec3f Plastic::evaluate(const Vec3f& colour, const Vec3f& wo, const Vec3f& wi, float& pdf) const {
    pdf = 0;
    if (wi.z() <= 0 || wo.z() <= 0) return Vec3f::Zero();
    const float chance = coat_chance(colour, wo);
    Vec3f f = colour * remaining_lobe(coat_, wo, wi);
    float coat_pdf = 0;
    if (!smooth()) {
        const Vec3f h = (wo + wi).normalized();
        coat_pdf = visible_reflection_pdf(wo, h, roughness_);
        const float reflectance = fresnel(wo.dot(h), ior_), facets = facet_reflection(wo, wi, h, roughness_);
        for (float& channel : f) channel = std::fma(reflectance, facets, channel);
    }
    pdf = chance * coat_pdf + (1 - chance) * (wi.z() / kPif);
    return f;
}

Scatter Plastic::scatter(const Vec3f& colour, const Vec3f& wo, float choose, const Vec2f& u) const {
    Scatter scattered;
    if (wo.z() <= 0) return scattered;
    const float chance = coat_chance(colour, wo);
    if (choose < chance && smooth()) {
        scattered.direction = mirrored(wo);
        scattered.pdf = std::numeric_limits<float>::infinity();
        scattered.weight = Vec3f::Constant(fresnel(wo.z(), ior_)) / chance;
        return scattered;
    }
    scattered.direction = choose < chance ? sample_reflection(wo, roughness_, u) : sample_cosine(u);
    const Vec3f f = evaluate(colour, wo, scattered.direction, scattered.pdf);
    if (scattered.pdf > 0) scattered.weight = f / scattered.pdf;
    return scattered;
}

Vec3f Plastic::albedo(const Vec3f& colour, float cosine) const {
    const float e = coat_(cosine);
    return Vec3f::Constant(e) + (1 - e) * colour;
}

}  // namespace thixo::render
