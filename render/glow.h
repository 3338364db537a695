// Light that surfaces give by themselves.
#pragma once

#include "pipeline/contract/scene.h"
#include "render/ray.h"

namespace thixo::render {

/// Radiance, the same to all sides on which a ray can meet the surface: e, or for matter that glows by its heat
///
///   e L(T, reference)   (black_body_radiance)   [W/(m^2 sr)]
class Glow {
  public:
    Glow() = default;
    explicit Glow(const scene::Glow& glow);
    bool any() const { return any_; }
    bool by_temperature() const { return reference_ > 0; }
    Vec3f at(const Hit& hit) const;

  private:
    bool any_ = false;
    Vec3f radiance_{0, 0, 0};
    float reference_ = 0;  // K; 0: the temperature does not matter
};

}  // namespace thixo::render
