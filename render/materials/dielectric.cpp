#include "render/materials/dielectric.h"

#include <cmath>

namespace thixo::render {
namespace {

constexpr float kLargestIndex = 4;

float index_at(int k) {
    return std::exp(std::log(kLargestIndex) * (2 * float(k) / float(InterfaceAlbedo::kIndices - 1) - 1));
}

/// f(table k, table k + 1, share of the second) for an index of refraction.
template <class F>
float between(float eta, F&& f) {
    const float x = 0.5f * (std::log(eta) / std::log(kLargestIndex) + 1) * float(InterfaceAlbedo::kIndices - 1);
    const float inside = std::clamp(x, 0.0f, float(InterfaceAlbedo::kIndices - 1));
    const int k = std::min(int(inside), InterfaceAlbedo::kIndices - 2);
    const float share = inside - float(k);
    return (1 - share) * f(k) + share * f(k + 1);
}

/// The direction refracted at a facet h, wo.h > 0; false: total reflection.
bool refracted(const Vec3f& wo, const Vec3f& h, float eta, float& reflectance, Vec3f& wi) {
    float cos_t;
    const float cosine = wo.dot(h);
    reflectance = fresnel(cosine, eta, cos_t);
    if (reflectance >= 1) return false;
    wi = -wo / eta + (cosine / eta - cos_t) * h;
    return true;
}

/// Masking and shadowing of a path that is refracted: each side on its own.
float masking(const Vec3f& wo, const Vec3f& wi, float alpha) { return ggx_g1(wo, alpha) * ggx_g1(wi, alpha); }

}  // namespace

float InterfaceAlbedo::of(float mu, float eta) const {
    return between(eta, [&](int k) { return at[std::size_t(k)](mu); });
}
float InterfaceAlbedo::mean(float eta) const {
    return between(eta, [&](int k) { return at[std::size_t(k)].mean; });
}
float InterfaceAlbedo::mean_reflectance(float eta) const {
    return between(eta, [&](int k) { return reflectance[std::size_t(k)]; });
}

InterfaceAlbedo tabulate_interface(float alpha) {
    constexpr int samples = 512;
    InterfaceAlbedo table;
    for (int k = 0; k < InterfaceAlbedo::kIndices; ++k) {
        const float eta = index_at(k);
        double reflected = 0;
        AlbedoTable& albedo = table.at[std::size_t(k)];
        for (int step = 0; step <= AlbedoTable::kSteps; ++step) {
            const float mu = std::max(float(step) / AlbedoTable::kSteps, 1e-3f);
            const Vec3f wo(std::sqrt(1 - mu * mu), 0, mu);
            double sum = 0;
            for (int i = 0; i < samples; ++i) {
                const Vec3f h = sample_visible_normal(wo, alpha, lattice(i, samples));
                float f;
                Vec3f through;
                const bool passes = refracted(wo, h, eta, f, through);
                const Vec3f back = 2 * wo.dot(h) * h - wo;
                if (back.z() > 0) sum += double(f * ggx_g2(wo, back, alpha) / ggx_g1(wo, alpha));
                if (passes && through.z() < 0) sum += double((1 - f) * ggx_g1(through, alpha));
            }
            albedo.at[std::size_t(step)] = float(sum / samples);
            const double weight = step == 0 || step == AlbedoTable::kSteps ? 0.5 : 1;
            reflected += weight * 2 * double(fresnel(mu, eta)) * double(mu) / AlbedoTable::kSteps;
        }
        add_mean(albedo);
        table.reflectance[std::size_t(k)] = float(reflected);
    }
    return table;
}

Dielectric::Dielectric(const scene::Appearance& a)
    : roughness(float(a.roughness)), ior(float(a.ior)), absorption(a.absorption.cast<float>()), priority(a.priority) {
    if (!smooth()) table = std::make_shared<const InterfaceAlbedo>(tabulate_interface(roughness));
}

float RoughInterface::single_reflection(const Vec3f& wo, const Vec3f& wi, float& pdf) const {
    const Vec3f h = (wo + wi).normalized();
    const float f = fresnel(wo.dot(h), eta);
    pdf = f * visible_reflection_pdf(wo, h, alpha);
    return f * ggx_d(h, alpha) * ggx_g2(wo, wi, alpha) / (4 * std::max(wo.z(), 1e-6f));
}

float RoughInterface::single_refraction(const Vec3f& wo, const Vec3f& wi, float& pdf) const {
    pdf = 0;
    Vec3f h = -(wo + eta * wi);
    if (h.z() < 0) h = -h;
    h.normalize();
    const float o = wo.dot(h), i = wi.dot(h);
    if (o <= 0 || i >= 0) return 0;
    const float f = fresnel(o, eta);
    const float jacobian = square(eta) * -i / std::max(square(o + eta * i), 1e-12f);
    const float common = (1 - f) * ggx_d(h, alpha) * o / std::max(wo.z(), 1e-6f) * jacobian;
    pdf = common * ggx_g1(wo, alpha);
    return common * masking(wo, wi, alpha) / square(eta);
}

/// How the multiply scattered light of this side is shared: the part that goes through. With 1 - F for the means of
/// both sides, and (1 - F) (1 - E) alike seen from either side, f/n^2 is symmetric.
float RoughInterface::share_through() const {
    const float own = 1 - table->mean(eta), other = 1 - table->mean(1 / eta);
    return (1 - table->mean_reflectance(eta)) * std::min(1.0f, other / std::max(own, 1e-9f));
}

float RoughInterface::evaluate(const Vec3f& wo, const Vec3f& wi, float& pdf) const {
    pdf = 0;
    if (wo.z() <= 0 || wi.z() == 0) return 0;
    const bool through = wi.z() < 0;
    const float single = table->of(wo.z(), eta), cosine = std::abs(wi.z()) / kPif, shared = share_through();
    float pdf_single = 0;
    float f = through ? single_refraction(wo, wi, pdf_single) : single_reflection(wo, wi, pdf_single);
    const float eta_behind = through ? 1 / eta : eta;
    const float lost = std::max(1 - table->mean(eta_behind), 1e-6f);
    float several = (1 - single) * (1 - table->of(std::abs(wi.z()), eta_behind)) / lost * cosine;
    several *= through ? shared / square(eta) : 1 - shared;
    pdf = single * pdf_single + (1 - single) * (through ? shared : 1 - shared) * cosine;
    return f + several;
}

Scatter RoughInterface::scatter(const Vec3f& wo, float choose, const Vec2f& u) const {
    Scatter scattered;
    if (wo.z() <= 0) return scattered;
    const float single = table->of(wo.z(), eta);
    if (choose < single) {
        const Vec3f h = sample_visible_normal(wo, alpha, u);
        float f;
        const bool passes = refracted(wo, h, eta, f, scattered.direction);
        const bool back = !passes || choose / single < f;
        if (back) scattered.direction = 2 * wo.dot(h) * h - wo;
        const bool out = back == (scattered.direction.z() > 0);
        if (!out) return scattered;  // into the next facet: the table counts it as lost
    } else {
        scattered.direction = sample_cosine(u);
        if ((choose - single) / (1 - single) < share_through()) scattered.direction.z() = -scattered.direction.z();
    }
    const float f = evaluate(wo, scattered.direction, scattered.pdf);
    if (scattered.pdf > 0) scattered.weight = Vec3f::Constant(f / scattered.pdf);
    return scattered;
}

}  // namespace thixo::render
