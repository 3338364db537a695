// Plastic: a matt base under a clear coat that is smooth or rough (Kelemen & Szirmay-Kalos 2001).
#pragma once

#include "pipeline/contract/scene.h"
#include "render/materials/albedo_table.h"
#include "render/materials/scatter.h"

namespace thixo::render {

class Plastic {
  public:
    static constexpr auto kType = scene::AppearanceType::plastic;
    explicit Plastic(const scene::Appearance& appearance);

    /// The coat reflects E(wo); the base scatters its colour's part of the rest.
    Vec3f evaluate(const Vec3f& colour, const Vec3f& wo, const Vec3f& wi, float& pdf) const;
    Scatter scatter(const Vec3f& colour, const Vec3f& wo, float choose, const Vec2f& u) const;
    Vec3f albedo(const Vec3f& colour, float cosine) const;

  private:
    bool smooth() const { return roughness_ < kSmooth; }
    float coat_chance(const Vec3f& colour, const Vec3f& wo) const;

    float roughness_;  // GGX alpha
    float ior_;
    AlbedoTable coat_;  // of the coat's reflection
};

}  // namespace thixo::render
