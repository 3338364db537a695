// GGX microfacets and Fresnel reflection. Local frame: normal along +z. Sources: Walter et al. 2007, Heitz 2018.
#pragma once

#include "render/warp.h"

namespace thixo::render {

/// Unpolarised reflectance of a smooth interface, met from the side of the incident ray at cosine >= 0:
///   eta = n_other / n_incident
/// One where the reflection is total. `cos_t` becomes the cosine on the other side.
inline float fresnel(float cosine, float eta, float& cos_t) {
    const float sin2 = std::max(0.0f, 1 - cosine * cosine) / (eta * eta);
    if (sin2 >= 1) {
        cos_t = 0;
        return 1;
    }
    cos_t = std::sqrt(1 - sin2);
    const float parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t),
                normal = (cosine - eta * cos_t) / (cosine + eta * cos_t);
    return 0.5f * (parallel * parallel + normal * normal);
}
inline float fresnel(float cosine, float eta) {
    float unused;
    return fresnel(cosine, eta, unused);
}

/// Reflectance of a metal from that at normal incidence (Schlick 1994).
inline Vec3f schlick(const Vec3f& f0, float cosine) {
    const float m = std::clamp(1 - cosine, 0.0f, 1.0f), m2 = m * m;
    return f0 + (Vec3f::Ones() - f0) * (m2 * m2 * m);
}

/// Trowbridge-Reitz distribution of normals, D(h) [1/sr].
inline float ggx_d(const Vec3f& h, float alpha) {
    const float a2 = alpha * alpha, k = h.z() * h.z() * (a2 - 1) + 1;
    return a2 / (kPif * k * k);
}
/// Smith's Lambda.
inline float ggx_lambda(const Vec3f& w, float alpha) {
    const float z2 = w.z() * w.z();
    return 0.5f * (std::sqrt(1 + alpha * alpha * std::max(0.0f, 1 - z2) / std::max(z2, 1e-12f)) - 1);
}
inline float ggx_g1(const Vec3f& w, float alpha) { return 1 / (1 + ggx_lambda(w, alpha)); }
/// Height-correlated masking and shadowing.
inline float ggx_g2(const Vec3f& wo, const Vec3f& wi, float alpha) {
    return 1 / (1 + ggx_lambda(wo, alpha) + ggx_lambda(wi, alpha));
}

/// A normal out of those visible from wo (Heitz 2018). Its density is
///   G1(wo) D(h) max(0, wo.h) / wo.z   [1/sr]
inline Vec3f sample_visible_normal(const Vec3f& wo, float alpha, const Vec2f& u) {
    const Vec3f v = Vec3f(alpha * wo.x(), alpha * wo.y(), wo.z()).normalized();
    const float length2 = v.x() * v.x() + v.y() * v.y();
    const Vec3f t1 = length2 > 0 ? Vec3f(Vec3f(-v.y(), v.x(), 0) / std::sqrt(length2)) : Vec3f(1, 0, 0);
    const Vec3f t2 = v.cross(t1);
    const Vec2f d = sample_disc(u);
    const float s = 0.5f * (1 + v.z());
    const float y = (1 - s) * std::sqrt(std::max(0.0f, 1 - d.x() * d.x())) + s * d.y();
    const Vec3f h = d.x() * t1 + y * t2 + std::sqrt(std::max(0.0f, 1 - d.x() * d.x() - y * y)) * v;
    return Vec3f(alpha * h.x(), alpha * h.y(), std::max(1e-6f, h.z())).normalized();
}
/// The direction that one reflection at such a normal gives.
inline Vec3f sample_reflection(const Vec3f& wo, float alpha, const Vec2f& u) {
    const Vec3f h = sample_visible_normal(wo, alpha, u);
    return 2 * wo.dot(h) * h - wo;
}
/// Its density [1/sr].
inline float visible_reflection_pdf(const Vec3f& wo, const Vec3f& h, float alpha) {
    return ggx_g1(wo, alpha) * ggx_d(h, alpha) / (4 * std::max(wo.z(), 1e-6f));
}
/// One reflection at facets that reflect everything, times cos(wi):
///   D(h) G2(wo, wi) / (4 cos(wo))   [1/sr],   h half-way between wo and wi
inline float facet_reflection(const Vec3f& wo, const Vec3f& wi, const Vec3f& h, float alpha) {
    return ggx_d(h, alpha) * ggx_g2(wo, wi, alpha) / (4 * std::max(wo.z(), 1e-6f));
}

}  // namespace thixo::render
