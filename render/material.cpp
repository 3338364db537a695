#include "render/material.h"

#include "pipeline/base/error.h"
#include "render/microfacet.h"
#include "render/rough_interface.h"

namespace thixo::render {
namespace {

using scene::AppearanceType;

Vec3f mirrored(const Vec3f& w) { return {-w.x(), -w.y(), w.z()}; }

/// E(mu) by visible normals: the mean of F G2/G1 over sampled reflections.
template <class Fresnel>
Albedo tabulate(float alpha, Fresnel&& reflectance) {
    constexpr int samples = 1024;
    Albedo table;
    for (int k = 0; k <= Albedo::kSteps; ++k) {
        const float mu = std::max(float(k) / Albedo::kSteps, 1e-3f);
        const Vec3f wo(std::sqrt(1 - mu * mu), 0, mu);
        double sum = 0;
        for (int i = 0; i < samples; ++i) {
            const Vec3f h = sample_visible_normal(wo, alpha, lattice(i, samples));
            const Vec3f wi = 2 * wo.dot(h) * h - wo;
            if (wi.z() > 0) sum += double(reflectance(wo.dot(h)) * ggx_g2(wo, wi, alpha) / ggx_g1(wo, alpha));
        }
        table.at[k] = float(sum / samples);
    }
    return table;
}

Albedo tabulate_smooth(float ior) {
    Albedo table;
    for (int k = 0; k <= Albedo::kSteps; ++k) table.at[k] = fresnel(float(k) / Albedo::kSteps, ior);
    return table;
}

/// Mean of Schlick's reflectance, 2 int F mu dmu.
Vec3f mean_schlick(const Vec3f& f0) { return f0 + (Vec3f::Ones() - f0) / 21.0f; }

/// What metal's multiple scattering keeps: the lobe is this times (1 - E(wo)) (1 - E(wi)) / (pi (1 - E mean)).
Vec3f multiple_colour(const Material& m, const Vec3f& colour) {
    const Vec3f f = mean_schlick(colour);
    return (f.array().square() * m.albedo.mean / (1 - f.array() * (1 - m.albedo.mean))).matrix();
}

/// Chance of the reflecting lobe; the rest goes to the diffuse-like one.
float reflect_chance(const Material& m, const Vec3f& colour, const Vec3f& wo) {
    const float e = m.albedo(wo.z());
    if (m.type == AppearanceType::conductor) return std::max(0.25f, e);
    return std::clamp(e / std::max(e + (1 - e) * luminance(colour), 1e-6f), 0.1f, 0.9f);
}

Vec3f coupled(const Material& m, const Vec3f& colour, const Vec3f& wo, const Vec3f& wi) {
    const float lost = std::max(1 - m.albedo.mean, 1e-6f);
    return colour * ((1 - m.albedo(wo.z())) * (1 - m.albedo(wi.z())) / lost * wi.z() / kPif);
}

/// The rough reflecting lobe, f cos.
Vec3f reflection(const Material& m, const Vec3f& colour, const Vec3f& wo, const Vec3f& wi, float& pdf) {
    const Vec3f h = (wo + wi).normalized();
    pdf = visible_reflection_pdf(wo, h, m.roughness);
    const float cosine = wo.dot(h);
    const Vec3f f =
        m.type == AppearanceType::conductor ? schlick(colour, cosine) : Vec3f(Vec3f::Constant(fresnel(cosine, m.ior)));
    return f * (ggx_d(h, m.roughness) * ggx_g2(wo, wi, m.roughness) / (4 * std::max(wo.z(), 1e-6f)));
}

}  // namespace

Vec2f lattice(int i, int n) {
    const double g = double(i) * 0.6180339887498949;
    return {float((i + 0.5) / n), float(g - std::floor(g))};
}

void add_mean(Albedo& table) {
    double sum = 0;
    const double step = 1.0 / Albedo::kSteps;
    for (int k = 0; k < Albedo::kSteps; ++k) {
        const double a = table.at[k], b = table.at[k + 1], m = k * step;
        sum += 2 * step * (0.5 * m * (a + b) + step * (a / 6 + b / 3));
    }
    table.mean = float(sum);
}

namespace {

Vec3f mapped(const std::vector<std::pair<float, Vec3f>>& map, float value) {
    if (value <= map.front().first) return map.front().second;
    for (std::size_t k = 1; k < map.size(); ++k) {
        const auto& [a, below] = map[k - 1];
        const auto& [b, above] = map[k];
        if (value < b) return below + (value - a) / (b - a) * (above - below);
    }
    return map.back().second;
}

}  // namespace

Vec3f Material::colour_at(const Hit& hit) const {
    if (colour_by != scene::ColourBy::none)
        return mapped(colour_map, colour_by == scene::ColourBy::temperature ? hit.attributes.temperature
                                                                            : hit.attributes.velocity.norm());
    if (image.texture) return image.colour(hit, in_rest);
    if (checker <= 0) return colour;
    const Vec3f& position = in_rest ? hit.attributes.rest : hit.position;
    const auto field = [&](float x) { return std::int64_t(std::floor(x / checker)); };
    return ((field(position.x()) + field(position.y())) & 1) == 0 ? colour : colour2;
}

Material make_material(const scene::Appearance& a, std::shared_ptr<const Texture> texture) {
    THIXO_ASSERT(a.image.file.empty() == !texture, "appearance {}: image '{}'", a.name, a.image.file);
    Material m;
    m.type = a.type;
    m.colour = a.colour.cast<float>();
    m.colour2 = a.colour2.cast<float>();
    m.checker = float(a.checker);
    m.in_rest = a.space == scene::Space::rest && (a.checker > 0 || texture);
    m.image = {std::move(texture), a.image.mapping, int(a.image.axis), a.image.origin.cast<float>(),
               a.image.size.cast<float>()};
    m.colour_by = a.colour_by;
    for (const scene::ColourStop& c : a.colour_map) m.colour_map.emplace_back(float(c.at), c.colour.cast<float>());
    m.bump = {float(a.bumps.amplitude), float(a.bumps.scale), a.bumps.octaves};
    m.roughness = float(a.roughness);
    m.ior = float(a.ior);
    m.absorption = a.absorption.cast<float>();
    m.priority = a.priority;
    if (m.dielectric() && !m.smooth())
        m.interface = std::make_shared<const InterfaceAlbedo>(tabulate_interface(m.roughness));
    if (m.type == AppearanceType::conductor && !m.smooth())
        m.albedo = tabulate(m.roughness, [](float) { return 1.0f; });
    if (m.type == AppearanceType::plastic)
        m.albedo =
            m.smooth() ? tabulate_smooth(m.ior) : tabulate(m.roughness, [&](float c) { return fresnel(c, m.ior); });
    add_mean(m.albedo);
    return m;
}

Vec3f evaluate(const Material& m, const Vec3f& colour, const Vec3f& wo, const Vec3f& wi, float& pdf) {
    pdf = 0;
    if (wi.z() <= 0 || wo.z() <= 0) return Vec3f::Zero();
    const float cosine_pdf = wi.z() / kPif;
    if (m.type == AppearanceType::diffuse) {
        pdf = cosine_pdf;
        return colour * cosine_pdf;
    }
    const bool metal = m.type == AppearanceType::conductor;
    if (metal && m.smooth()) return Vec3f::Zero();
    const float chance = reflect_chance(m, colour, wo);
    Vec3f f = coupled(m, metal ? multiple_colour(m, colour) : colour, wo, wi);
    float reflect_pdf = 0;
    if (!m.smooth()) f += reflection(m, colour, wo, wi, reflect_pdf);
    pdf = chance * reflect_pdf + (1 - chance) * cosine_pdf;
    return f;
}

Scatter scatter(const Material& m, const Vec3f& colour, const Vec3f& wo, float choose, const Vec2f& u) {
    Scatter s;
    if (wo.z() <= 0) return s;
    const bool metal = m.type == AppearanceType::conductor;
    const float chance = m.type == AppearanceType::diffuse ? 0
                         : metal && m.smooth()             ? 1
                                                           : reflect_chance(m, colour, wo);
    if (choose < chance && m.smooth()) {
        s.direction = mirrored(wo);
        s.pdf = std::numeric_limits<float>::infinity();
        s.weight = (metal ? schlick(colour, wo.z()) : Vec3f(Vec3f::Constant(fresnel(wo.z(), m.ior)))) / chance;
        return s;
    }
    if (choose < chance) {
        const Vec3f h = sample_visible_normal(wo, m.roughness, u);
        s.direction = 2 * wo.dot(h) * h - wo;
    } else {
        s.direction = sample_cosine(u);
    }
    const Vec3f f = evaluate(m, colour, wo, s.direction, s.pdf);
    if (s.pdf > 0) s.weight = f / s.pdf;
    return s;
}

}  // namespace thixo::render
