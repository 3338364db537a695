#include "pipeline/contract/scene_defaults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "pipeline/contract/scene_build.h"
#include "pipeline/contract/scene_extent.h"
#include "pipeline/contract/scene_walk.h"

namespace thixo::scene {
namespace {

constexpr double kGround = 0.35;  // albedo of boundaries
constexpr double kThick = 1;      // Pa s; syrup and honey have more

bool is_thick(const Material& m) {
    if (m.melting.any()) return m.melting.liquid.viscosity >= kThick;
    return !m.elastic.solid() && m.viscosity >= kThick;
}

bool holds_thick_liquid(const Scene& scene) {
    return std::ranges::any_of(scene.materials, [&](const Material& m) {
        const auto is_of = [&](const auto& source) { return source.material == m.name; };
        return is_thick(m) && (std::ranges::any_of(scene.bodies, is_of) || std::ranges::any_of(scene.emitters, is_of));
    });
}

// The name of a scene that gives none: its file's.
std::string name_of_file(const std::string& path) {
    std::string name = std::filesystem::path(path).stem().string().substr(0, 64);
    for (char& c : name)
        if (!is_name(std::string("x") + c)) c = '_';
    if (!is_name(name)) name = "scene" + name.substr(0, 59);
    return name;
}

std::vector<Light> default_lights() {
    Light sky, sun;
    sky.name = "sky";
    sky.type = LightType::sky;
    sky.colour = Vec3d(0.75, 0.87, 1.0);
    sky.strength = 0.8;
    sun.name = "sun";
    sun.type = LightType::sun;
    sun.colour = Vec3d(1.0, 0.95, 0.88);
    sun.strength = 2.5;
    sun.direction = Vec3d(0.5, 0.6, -1.0);
    return {sky, sun};
}

bool has(const Look& look, const std::string& name) {
    return std::ranges::any_of(look.appearances, [&](const Appearance& a) { return a.name == name; });
}

// Colours that are told apart, also by most who see fewer of them (after Okabe and Ito 2008), linear Rec.709.
constexpr std::array<std::array<double, 3>, 6> kColours{{{0.79, 0.13, 0.0},
                                                         {0.0, 0.34, 0.17},
                                                         {0.79, 0.35, 0.0},
                                                         {0.0, 0.17, 0.45},
                                                         {0.60, 0.19, 0.39},
                                                         {0.09, 0.46, 0.82}}};
constexpr double kDepth = 50;  // spacings of a liquid that its colour is seen through

Vec3d colour_of(std::size_t number) { return Vec3d(kColours[number % kColours.size()].data()); }

/// How a material looks that has no appearance: thin liquids like water, thick ones and solids like coloured plastic.
/// The first liquid is clear.
Appearance plain_look(const Material& m, std::size_t number, double spacing) {
    Appearance a;
    a.colour = colour_of(number);
    a.type = AppearanceType::plastic;
    a.roughness = m.elastic.solid() ? 0.4 : 0.1;
    if (m.elastic.solid() || is_thick(m)) return a;
    a.type = AppearanceType::dielectric;
    a.ior = 1.33;
    a.roughness = 0;
    if (number > 0) a.absorption = (Vec3d::Ones() - a.colour) / (kDepth * spacing);
    return a;
}

/// Gives what refers to no appearance the one of its own name, and makes that where there is none.
void add_default_appearance(Look& look, std::string& reference, const std::string& name, Appearance made) {
    if (!reference.empty()) return;
    reference = name;
    if (has(look, name)) return;
    made.name = name;
    look.appearances.push_back(std::move(made));
}

/// From in front, to the right and above, so that a ball about the scene just fits into the picture.
void fit_camera(const Scene& scene, Camera& camera, const Output& output) {
    const std::optional<Extent> extent = extent_of(scene);
    if (!extent) return;
    const double across = std::tan(camera.fov * kPi / 360);
    const double narrow = std::atan(across * std::min(1.0, double(output.height) / output.width));
    const double away = 0.5 * (extent->upper - extent->lower).norm() / std::sin(narrow);
    camera.look_at = 0.5 * (extent->lower + extent->upper);
    camera.position = camera.look_at + away * Vec3d(0.45, -1, 0.4).normalized();
}

}  // namespace

void fill_in(Scene& scene, const std::string& source_name, const Where& where) {
    if (scene.name.empty()) scene.name = name_of_file(source_name);
    std::size_t number = 0;
    for (Material& m : scene.materials) {
        Appearance made = plain_look(m, number, scene.solver.spacing);
        const auto is_mesh = [&](const Body& b) { return b.material == m.name && holds_mesh(scene, b.shape); };
        if (std::ranges::any_of(scene.bodies, is_mesh)) made.colour_by = ColourBy::vertices;
        add_default_appearance(scene.look, m.look, m.name, std::move(made));
        ++number;
    }
    for (Boundary& b : scene.world.boundaries) {
        Appearance ground;
        ground.colour = Vec3d::Constant(kGround);
        if (holds_mesh(scene, b.shape)) ground.colour_by = ColourBy::vertices;
        add_default_appearance(scene.look, b.look, b.name, std::move(ground));
    }
    const auto given = [&](const char* key) { return where.find(key) != where.end(); };
    if (!given("look.camera.position") && !given("look.camera.look_at") && scene.look.camera.path.empty())
        fit_camera(scene, scene.look.camera, scene.look.output);
}

bool is_default_light(const Light& light) {
    // Earlier caches state the direction that is meant where none is given.
    const auto text = [](Light l) {
        l.direction = l.direction.value_or(light_direction(Light()));
        return print_value(to_block(l));
    };
    return std::ranges::any_of(default_lights(),
                               [&](const Light& l) { return l.name == light.name && text(l) == text(light); });
}

void settle_defaults(Scene& scene, const Where& where) {
    const auto given = [&](const std::string& path) { return where.find(path) != where.end(); };
    for (Emitter& e : scene.emitters)
        if (e.rate > 0 && !given("emitters." + e.name + ".speed")) e.speed = 0;
    for (Material& m : scene.materials)
        if (!m.elastic.orthotropic.any() && !given("materials." + m.name + ".volume_stiffness"))
            m.elastic.volume_stiffness = m.elastic.youngs_modulus;
    if (!given("look.lights")) scene.look.lights = default_lights();
    const bool thick = holds_thick_liquid(scene);
    for (Boundary& b : scene.world.boundaries)
        if (thick && !given("world.boundaries." + b.name + ".no_slip")) b.no_slip = true;
}

}  // namespace thixo::scene
