#include "render/materials/conductor.h"

namespace thixo::render {
namespace {

/// Mean of Schlick's reflectance F(mu):
///   2 int F mu dmu   over [0, 1].
Vec3f mean_schlick(const Vec3f& f0) { return f0 + (Vec3f::Ones() - f0) / 21.0f; }

}  // namespace

Conductor::Conductor(const scene::Appearance& a) : roughness_(float(a.roughness)) {
    if (smooth()) return;
    reflection_ = tabulate_reflection(roughness_, [](float) { return 1.0f; });
    grazing_ = tabulate_reflection(roughness_, [](float cosine) { return schlick(Vec3f::Zero(), cosine).x(); });
}

/// What multiple scattering keeps: the factor of the second lobe.
Vec3f Conductor::multiple_colour(const Vec3f& colour) const {
    const Vec3f f = mean_schlick(colour);
    return (f.array().square() * reflection_.mean / (1 - f.array() * (1 - reflection_.mean))).matrix();
}

/// Chance of the reflecting lobe; the rest goes to the diffuse-like one.
float Conductor::reflect_chance(const Vec3f& wo) const { return std::max(0.25f, reflection_(wo.z())); }

Vec3f Conductor::evaluate(const Vec3f& colour, const Vec3f& wo, const Vec3f& wi, float& pdf) const {
    pdf = 0;
    if (wi.z() <= 0 || wo.z() <= 0 || smooth()) return Vec3f::Zero();
    const float chance = reflect_chance(wo);
    const Vec3f h = (wo + wi).normalized();
    pdf = chance * visible_reflection_pdf(wo, h, roughness_) + (1 - chance) * (wi.z() / kPif);
    const Vec3f several = multiple_colour(colour) * remaining_lobe(reflection_, wo, wi);
    return several + schlick(colour, wo.dot(h)) * facet_reflection(wo, wi, h, roughness_);
}

Scatter Conductor::scatter(const Vec3f& colour, const Vec3f& wo, float choose, const Vec2f& u) const {
    Scatter scattered;
    if (wo.z() <= 0) return scattered;
    if (smooth()) {
        scattered.direction = mirrored(wo);
        scattered.pdf = std::numeric_limits<float>::infinity();
        scattered.weight = schlick(colour, wo.z());
        return scattered;
    }
    scattered.direction = choose < reflect_chance(wo) ? sample_reflection(wo, roughness_, u) : sample_cosine(u);
    const Vec3f f = evaluate(colour, wo, scattered.direction, scattered.pdf);
    if (scattered.pdf > 0) scattered.weight = f / scattered.pdf;
    return scattered;
}

/// Schlick's reflectance is linear in the colour, so that two tables hold the albedo for all colours:
///   E = c E_1 + (1 - c) E_grazing + multiple (1 - E_1)
Vec3f Conductor::albedo(const Vec3f& colour, float cosine) const {
    if (smooth()) return schlick(colour, cosine);
    const float e = reflection_(cosine);
    return colour * e + (Vec3f::Ones() - colour) * grazing_(cosine) + multiple_colour(colour) * (1 - e);
}

}  // namespace thixo::render
