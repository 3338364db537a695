// An appearance made ready: which material a surface is of, and which colour it has where.
#pragma once

#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "pipeline/contract/scene.h"
#include "render/glow.h"
#include "render/image_map.h"
#include "render/materials/conductor.h"
#include "render/materials/dielectric.h"
#include "render/materials/diffuse.h"
#include "render/materials/plastic.h"
#include "render/noise.h"

namespace thixo::render {

/// Materials that let no light through, each a file of its own (materials/scatter.h says what it states).
using Opaque = std::variant<Diffuse, Plastic, Conductor>;

struct Material {
    std::variant<Opaque, Dielectric> surface;
    Vec3f colour{0.8f, 0.8f, 0.8f}, colour2{0.3f, 0.3f, 0.3f};
    float checker = 0;  // m
    ImageMap image;
    bool in_rest = false;  // checker and image are in m0, not in the world
    scene::ColourBy colour_by = scene::ColourBy::none;
    std::vector<std::pair<float, Vec3f>> colour_map;  // ascending
    Bump bump;
    Glow glow;  // of an opaque material

    /// Null for an opaque material.
    const Dielectric* dielectric() const { return std::get_if<Dielectric>(&surface); }
    /// Lets light through in a straight line, but for refraction.
    bool clear() const { return dielectric() && dielectric()->smooth(); }
    /// Whether it looks at the attributes of a hit.
    bool reads_attributes() const {
        return in_rest || image.by_uv() || colour_by != scene::ColourBy::none || bump.amplitude > 0 ||
               glow.by_temperature();
    }
    /// Colour at a hit: the attribute's, the mesh's own, the image's, the checker's field, or plain.
    Vec3f colour_at(const Hit& hit) const;

    // Of an opaque material, as materials/scatter.h has it.
    Vec3f evaluate(const Vec3f& at, const Vec3f& wo, const Vec3f& wi, float& pdf) const;
    Scatter scatter(const Vec3f& at, const Vec3f& wo, float choose, const Vec2f& u) const;
    Vec3f albedo(const Vec3f& at, float cosine) const;
};

/// An appearance with an image needs its texture.
Material make_material(const scene::Appearance& appearance, std::shared_ptr<const Texture> texture = nullptr);

}  // namespace thixo::render
