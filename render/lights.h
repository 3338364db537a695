// What shines: rectangles, suns, skies, environments, points and spots.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pipeline/contract/scene.h"
#include "render/environment.h"

namespace thixo::render {

/// A light made ready. Directions point from the lit place to the light.
struct Light {
    scene::LightType type = scene::LightType::sky;
    // Sun: of its disc; sky: at the zenith; area: of its front [W/(m^2 sr)]; point, spot: intensity [W/sr];
    // environment: a factor.
    Vec3f radiance{1, 1, 1};
    Vec3f horizon{1, 1, 1}, ground{0.3f, 0.3f, 0.3f};
    Vec3f normal{0, 0, -1};                                 // area, spot: where it shines to; sun: towards the sun
    Vec3f centre{0, 0, 0}, edge1{1, 0, 0}, edge2{0, 1, 0};  // area; edges are half lengths; point, spot: the centre
    float bright = 1, dark = -1;                            // spot: cosines within and without which it fades no more
    float area = 0;                                         // m^2
    float cone = 0;                                         // sun: 1 - cos(half its angular diameter)
    std::shared_ptr<const Environment> environment;
    Vec2f turn{1, 0};  // environment: cos and sin of its rotation
    /// Light from all sides, seen wherever nothing is in the way.
    bool surrounds() const { return type == scene::LightType::sky || type == scene::LightType::environment; }
    bool infinite() const { return type == scene::LightType::sun || surrounds(); }
    /// Without size: no ray meets it by chance.
    bool sizeless() const { return type == scene::LightType::point || type == scene::LightType::spot; }
};

/// A sun of irradiance E and half angle a has the radiance E/(pi sin^2 a); no sun is smaller than 0.01 degrees.
/// An environment needs its picture.
Light make_light(const scene::Light& light, std::shared_ptr<const Environment> environment = nullptr);

/// Radiance from direction d of a light at infinity. Of a sun: zero outside its disc. Of an environment: its picture's.
/// Of a sky:
///   zenith (horizon + (1 - horizon) d.z)   for d.z >= 0,
///   zenith ground                          below   [W/(m^2 sr)]
Vec3f infinite_radiance(const Light& light, const Vec3f& d);

struct LightSample {
    Vec3f direction{0, 0, 1};
    float distance = 0;  // m, infinite for suns and skies
    Vec3f radiance{0, 0, 0};
    float pdf = 0;  // 1/sr; 0: nothing to be had. Of a light without size 1, and the radiance is its irradiance
};

/// Chooses a direction to the light from a place with unit normal n. Skies: by the cosine about n;
/// environments: by their light.
LightSample sample_light(const Light& light, const Vec3f& position, const Vec3f& n, const Vec2f& u);

/// The density sample_light has for direction d; for area lights `distance` and the cosine at the light come from
/// hit_area.
float light_pdf(const Light& light, const Vec3f& n, const Vec3f& d, float distance);

/// Distance to the front of an area light along d, infinity where it is missed. Other lights are always missed.
float hit_area(const Light& light, const Vec3f& origin, const Vec3f& d);

/// About the irradiance a light could give at a place, by which lights share samples; nothing is in its way.
float light_strength(const Light& light, const Vec3f& position);

/// Lights whose shares of a picture are kept apart. Empty where nobody asks for them.
struct LightGroups {
    std::vector<std::string> names;  // the background, the others as the lights name them, the glow
    std::vector<Index> of_light;     // by light, into `names`
    std::size_t of_glow = 0;         // that of what glows, where anything does
    static constexpr std::size_t kBackground = 0;
};
/// A light that names no group is one of its own name. `glow`: some appearance glows.
LightGroups light_groups(const std::vector<scene::Light>& lights, bool glow = false);

}  // namespace thixo::render
