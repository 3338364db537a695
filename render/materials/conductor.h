// Metal: it reflects, smooth or rough. What scatters several times between its facets is given back by a second,
// diffuse-like lobe (Kulla & Conty 2017).
#pragma once

#include "pipeline/contract/scene.h"
#include "render/materials/albedo_table.h"
#include "render/materials/scatter.h"

namespace thixo::render {

/// `colour` is the reflectance at normal incidence.
class Conductor {
  public:
    static constexpr auto kType = scene::AppearanceType::conductor;
    explicit Conductor(const scene::Appearance& appearance);

    Vec3f evaluate(const Vec3f& colour, const Vec3f& wo, const Vec3f& wi, float& pdf) const;
    Scatter scatter(const Vec3f& colour, const Vec3f& wo, float choose, const Vec2f& u) const;
    Vec3f albedo(const Vec3f& colour, float cosine) const;

  private:
    bool smooth() const { return roughness_ < kSmooth; }
    Vec3f multiple_colour(const Vec3f& colour) const;
    float reflect_chance(const Vec3f& wo) const;

    float roughness_;         // GGX alpha
    AlbedoTable reflection_;  // of facets that reflect everything
    AlbedoTable grazing_;     // of facets that reflect (1 - cosine)^5
};

}  // namespace thixo::render
