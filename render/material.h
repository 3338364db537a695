// What surfaces do to light: matt, plastic, metal, glass.
#pragma once

#include <array>
#include <limits>
#include <memory>

#include "pipeline/contract/scene.h"
#include "render/image_map.h"
#include "render/noise.h"
#include "render/warp.h"

namespace thixo::render {

/// Roughness below which a surface counts as smooth.
inline constexpr float kSmooth = 1e-3f;

/// Directional albedo E(mu) of a rough reflection at 32 even steps of mu = cos, and its mean 2 int E mu dmu.
struct Albedo {
    static constexpr int kSteps = 32;
    std::array<float, kSteps + 1> at{};
    float mean = 0;
    float operator()(float mu) const {
        const float x = std::clamp(mu, 0.0f, 1.0f) * kSteps;
        const int i = std::min(int(x), kSteps - 1);
        return at[i] + (x - float(i)) * (at[i + 1] - at[i]);
    }
};

/// Fills in the mean of the piecewise linear E.
void add_mean(Albedo& table);
/// Point i of n of a rank-1 lattice (golden ratio).
Vec2f lattice(int i, int n);

struct InterfaceAlbedo;

/// An appearance made ready.
struct Material {
    scene::AppearanceType type = scene::AppearanceType::diffuse;
    Vec3f colour{0.8f, 0.8f, 0.8f}, colour2{0.3f, 0.3f, 0.3f};
    float checker = 0;  // m
    ImageMap image;
    bool in_rest = false;  // checker and image are in m0, not in the world
    scene::ColourBy colour_by = scene::ColourBy::none;
    std::vector<std::pair<float, Vec3f>> colour_map;  // ascending
    Bump bump;
    float roughness = 0;  // GGX alpha
    float ior = 1.5f;
    Vec3f absorption{0, 0, 0};  // 1/m
    int priority = 0;
    Albedo albedo;  // conductor: of a perfect mirror's roughness; plastic: of the coat
    std::shared_ptr<const InterfaceAlbedo> interface;  // rough dielectric

    bool dielectric() const { return type == scene::AppearanceType::dielectric; }
    bool smooth() const { return roughness < kSmooth; }
    /// Lets light through in a straight line, but for refraction.
    bool clear() const { return dielectric() && smooth(); }
    /// Whether it looks at the attributes of a hit.
    bool reads_attributes() const {
        return in_rest || image.by_uv() || colour_by != scene::ColourBy::none || bump.amplitude > 0;
    }
    /// Colour at a hit: the attribute's, the image's, the checker's field, or plain.
    Vec3f colour_at(const Hit& hit) const;
};

/// An appearance with an image needs its texture.
Material make_material(const scene::Appearance& appearance, std::shared_ptr<const Texture> texture = nullptr);

/// A direction chosen by an opaque surface. weight = f cos / pdf [1].
struct Scatter {
    Vec3f direction{0, 0, 1};  // local
    Vec3f weight{0, 0, 0};
    float pdf = 0;  // [1/sr]; infinite for a mirror direction
    bool mirror() const { return pdf == std::numeric_limits<float>::infinity(); }
};

/// f(wo, wi) cos(wi) [1/sr], and the density of scatter() in wi. Local frame, wo.z > 0; zero where wi.z <= 0 and for
/// mirror directions. Rough reflection keeps the energy of its multiple scattering by a second, diffuse-like lobe
/// (Kulla & Conty 2017); under plastic's coat the matt base gets (1 - E(wo)) (1 - E(wi)) / (pi (1 - E mean)) of its
/// colour (Kelemen & Szirmay-Kalos 2001).
Vec3f evaluate(const Material& material, const Vec3f& colour, const Vec3f& wo, const Vec3f& wi, float& pdf);

/// Chooses a direction; `choose` picks the lobe, u the direction. weight zero: absorbed.
Scatter scatter(const Material& material, const Vec3f& colour, const Vec3f& wo, float choose, const Vec2f& u);

}  // namespace thixo::render
