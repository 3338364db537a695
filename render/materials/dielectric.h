// Glass, water: a clear medium behind an interface that is smooth or rough. A rough interface between two media (Walter
// et al. 2007) has the light that scatters several times between its facets given back (Kulla & Conty 2017). A smooth
// one is met in path.cpp, where the surface's own normal counts beside the shading one.
#pragma once

#include <array>
#include <memory>

#include "pipeline/contract/scene.h"
#include "render/materials/albedo_table.h"
#include "render/materials/scatter.h"

namespace thixo::render {

/// Directional albedo of single scattering, reflected and refracted together, for one roughness:
///   E(mu, eta),   eta = n behind / n before from 1/4 to 4,
/// its mean 2 int E mu dmu, and the mean Fresnel reflectance 2 int F mu dmu.
struct InterfaceAlbedo {
    static constexpr int kIndices = 33;
    std::array<AlbedoTable, kIndices> at{};
    std::array<float, kIndices> reflectance{};
    float of(float mu, float eta) const;
    float mean(float eta) const;
    float mean_reflectance(float eta) const;
};
InterfaceAlbedo tabulate_interface(float alpha);

/// A rough interface. Local frame: +z on the side wo is on (the medium `before`); wi.z < 0 goes through.
struct RoughInterface {
    float alpha = 0.1f;
    float eta = 1.5f;  // n behind / n before
    const InterfaceAlbedo* table = nullptr;

    /// f(wo, wi) |cos(wi)| [1/sr] for radiance, and the density of scatter() in wi. What goes through has the factor
    ///   1 / eta^2
    /// of radiance. Single scattering reflects and refracts at facets. The rest, 1 - E, leaves cosine-like on either
    /// side, shared so that light may run either way.
    float evaluate(const Vec3f& wo, const Vec3f& wi, float& pdf) const;
    /// A direction on either side.
    Scatter scatter(const Vec3f& wo, float choose, const Vec2f& u) const;

  private:
    float single_reflection(const Vec3f& wo, const Vec3f& wi, float& pdf) const;
    float single_refraction(const Vec3f& wo, const Vec3f& wi, float& pdf) const;
    float share_through() const;
};

struct Dielectric {
    explicit Dielectric(const scene::Appearance& appearance);

    bool smooth() const { return roughness < kSmooth; }
    /// The interface as met on the way from one index of refraction to another.
    RoughInterface interface(float before, float after) const { return {roughness, after / before, table.get()}; }

    float roughness;  // GGX alpha
    float ior;
    Vec3f absorption;                              // [1/m]
    int priority;                                  // where two media overlap the higher one fills the place
    std::shared_ptr<const InterfaceAlbedo> table;  // rough
};

}  // namespace thixo::render
