// A rough interface between two clear media (Walter et al. 2007), with the light that scatters several times between
// its facets given back (Kulla & Conty 2017).
#pragma once

#include <memory>

#include "render/material.h"

namespace thixo::render {

/// Directional albedo of single scattering, reflected and refracted together, for one roughness: E(mu, eta) with
/// eta = n behind / n before from 1/4 to 4, its mean 2 int E mu dmu, and the mean Fresnel reflectance 2 int F mu dmu.
struct InterfaceAlbedo {
    static constexpr int kIndices = 33;
    std::array<Albedo, kIndices> at{};
    std::array<float, kIndices> reflectance{};
    float of(float mu, float eta) const;
    float mean(float eta) const;
    float mean_reflectance(float eta) const;
};
InterfaceAlbedo tabulate_interface(float alpha);

/// Local frame: +z on the side wo is on (the medium `before`); wi.z < 0 goes through.
struct RoughInterface {
    float alpha = 0.1f;
    float eta = 1.5f;  // n behind / n before
    const InterfaceAlbedo* albedo = nullptr;
};

/// f(wo, wi) |cos(wi)| [1/sr] for radiance, and the density of scatter() in wi. What goes through has the factor
/// 1/eta^2 of radiance. Single scattering reflects and refracts at facets; the rest, 1 - E, leaves cosine-like on
/// either side, shared so that light may run either way.
float evaluate(const RoughInterface& m, const Vec3f& wo, const Vec3f& wi, float& pdf);

/// Chooses a direction on either side.
Scatter scatter(const RoughInterface& m, const Vec3f& wo, float choose, const Vec2f& u);

}  // namespace thixo::render
