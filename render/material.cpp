#include "render/material.h"

#include <optional>
#include <type_traits>

#include "pipeline/base/error.h"
#include "render/checker.h"

namespace thixo::render {
namespace {

Vec3f mapped(const std::vector<std::pair<float, Vec3f>>& map, float value) {
    if (value <= map.front().first) return map.front().second;
    for (std::size_t k = 1; k < map.size(); ++k) {
        const auto& [a, below] = map[k - 1];
        const auto& [b, above] = map[k];
        if (value < b) return below + (value - a) / (b - a) * (above - below);
    }
    return map.back().second;
}

}  // namespace

Vec3f Material::colour_at(const Hit& hit) const {
    using scene::ColourBy;
    if (colour_by == ColourBy::temperature) return mapped(colour_map, hit.attributes.temperature);
    if (colour_by == ColourBy::speed) return mapped(colour_map, hit.attributes.velocity.norm());
    if (colour_by == ColourBy::vertices && hit.attributes.colour.minCoeff() >= 0) return hit.attributes.colour;
    if (image.texture) return image.colour(hit, in_rest);
    if (checker <= 0) return colour;
    const float share = checker_share(in_rest ? hit.attributes.rest : hit.position, seen_width(hit, in_rest), checker);
    return share * colour + (1 - share) * colour2;
}

namespace {

using Surface = std::variant<Opaque, Dielectric>;

/// Of the materials in a list of opaque ones, that of the appearance's type; nothing where it is none of them.
template <class... Kinds>
std::optional<Surface> make_opaque(const scene::Appearance& a, std::type_identity<std::variant<Kinds...>>) {
    std::optional<Surface> made;
    ((a.type == Kinds::kType && (made = Opaque(Kinds(a)), true)) || ...);
    return made;
}

Surface make_surface(const scene::Appearance& a) {
    if (std::optional<Surface> made = make_opaque(a, std::type_identity<Opaque>{})) return *std::move(made);
    THIXO_ASSERT(a.type == scene::AppearanceType::dielectric, "appearance {}: a type without a material", a.name);
    return Dielectric(a);
}

}  // namespace

Material make_material(const scene::Appearance& a, std::shared_ptr<const Texture> texture) {
    THIXO_ASSERT(a.image.file.empty() == !texture, "appearance {}: image '{}'", a.name, a.image.file);
    Material m{.surface = make_surface(a)};
    m.colour = a.colour.cast<float>();
    m.colour2 = a.colour2.cast<float>();
    m.checker = float(a.checker);
    m.in_rest = a.space == scene::Space::rest && (a.checker > 0 || texture);
    m.image = {std::move(texture), a.image.mapping, int(a.image.axis), a.image.origin.cast<float>(),
               a.image.size.cast<float>()};
    m.colour_by = a.colour_by;
    for (const scene::ColourStop& c : a.colour_map) m.colour_map.emplace_back(float(c.at), c.colour.cast<float>());
    m.glow = Glow(a.glow);
    m.bump = {float(a.bumps.amplitude), float(a.bumps.scale), a.bumps.octaves};
    return m;
}

Vec3f Material::evaluate(const Vec3f& at, const Vec3f& wo, const Vec3f& wi, float& pdf) const {
    return std::visit([&](const auto& m) { return m.evaluate(at, wo, wi, pdf); }, std::get<Opaque>(surface));
}
Scatter Material::scatter(const Vec3f& at, const Vec3f& wo, float choose, const Vec2f& u) const {
    return std::visit([&](const auto& m) { return m.scatter(at, wo, choose, u); }, std::get<Opaque>(surface));
}
Vec3f Material::albedo(const Vec3f& at, float cosine) const {
    return std::visit([&](const auto& m) { return m.albedo(at, cosine); }, std::get<Opaque>(surface));
}

}  // namespace thixo::render
