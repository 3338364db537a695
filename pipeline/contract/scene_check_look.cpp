// Checks of the look, and of what wears it.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "pipeline/contract/scene_check.h"
#include "pipeline/contract/scene_checker.h"
#include "pipeline/contract/scene_walk.h"

namespace thixo::scene {
namespace {

/// Whether any part of a shape is a mesh from a file, named shapes looked up.
bool holds_mesh(const Scene& scene, const Shape& shape, std::set<std::string>& seen) {
    bool holds = false;
    walk_shape(shape, "", [&](const Shape& part, const std::string&) {
        holds = holds || std::holds_alternative<MeshFile>(part.kind);
        const auto* named = std::get_if<NamedShape>(&part.kind);
        if (!named || !seen.insert(named->name).second) return;
        for (const auto& [name, other] : scene.shapes)
            if (name == named->name) holds = holds || holds_mesh(scene, other, seen);
    });
    return holds;
}

void check_glow(const Appearance& a, const std::string& path, const Checker& check) {
    check.require(!glows(a) || a.type != AppearanceType::dielectric, path + ".glow", "a dielectric cannot glow",
                  "opaque surfaces do: diffuse, plastic, conductor");
    check.require(a.glow.black_body == 0 || a.glow.black_body >= kColdestGlow, path + ".glow.black_body",
                  fmt::format("a black body of {} degC gives no light to speak of", a.glow.black_body),
                  fmt::format("{} or more; 0: the glow does not depend on the temperature", kColdestGlow));
}

void check_light(const Light& l, const Look& look, const Checker& check) {
    const std::string path = "look.lights." + l.name;
    check.require(l.group.empty() || is_name(l.group), path + ".group",
                  fmt::format("\"{}\" is no name of a group", l.group), "letters, digits, _ and -, at most 64");
    check.require(!look.output.passes.lights || group_of(l) != kBackgroundGroup, path,
                  fmt::format("the group \"{}\" is that of look.background", kBackgroundGroup), "write another group");
    check.require(!glows(look) || group_of(l) != kGlowGroup, path,
                  fmt::format("the group \"{}\" is that of what glows", kGlowGroup), "write another group");
    check.require(l.type != LightType::environment || !l.file.empty(), path,
                  fmt::format("the environment \"{}\" needs a \"file\"", l.name),
                  "an EXR or HDR, twice as wide as high");
    check.require(!l.direction || !l.look_at, path + ".look_at",
                  "\"look_at\" and \"direction\" both say where the light goes", "leave one of them out");
    check.require(light_direction(l).norm() > 1e-9, path + ".look_at",
                  fmt::format("\"look_at\" and \"position\" of the light \"{}\" are the same point", l.name));
}

/// Requires of what wears an appearance whose light follows the temperature that it has one.
void check_temperatures(const Scene& scene, const std::string& look, const std::string& wearer, const Checker& check) {
    for (const Appearance& a : scene.look.appearances)
        check.require(a.name != look || !glows(a) || a.glow.black_body == 0,
                      "look.appearances." + a.name + ".glow.black_body",
                      fmt::format("{} has no temperatures that it could glow by", wearer),
                      "leave black_body out and choose a colour");
}

}  // namespace

void check_look(const Look& look, ReadContext& context) {
    const Checker check{context};
    const Camera& c = look.camera;
    const auto check_view = [&](const Vec3d& position, const Vec3d& look_at, const std::string& path,
                                const std::string& up) {
        const Vec3d view = look_at - position;
        check.require(view.norm() > 1e-9, path + ".look_at",
                      "\"look_at\" and \"position\" of the camera are the same point");
        check.require(view.norm() <= 1e-9 || view.normalized().cross(c.up.normalized()).norm() > 1e-6, up,
                      "\"up\" of the camera points along its view", "write for example up: [0, 1, 0]");
    };
    if (c.path.empty()) check_view(c.position, c.look_at, "look.camera", "look.camera.up");
    for (std::size_t k = 0; k < c.path.size(); ++k) {
        const std::string path = fmt::format("look.camera.path.{}", k);
        check_view(c.path[k].position, c.path[k].look_at, path, path + ".look_at");
    }
    check_motion(c.motion, "look.camera.motion", check);
    for (std::size_t k = 1; k < c.path.size(); ++k)
        check.require(c.path[k].time > c.path[k - 1].time, fmt::format("look.camera.path.{}.time", k),
                      fmt::format("\"time\" must ascend: {} is not after {}", c.path[k].time, c.path[k - 1].time));
    check.require(
        c.shutter_open <= c.shutter_close, "look.camera.shutter_close",
        fmt::format("the shutter closes at {} frames, before it opens at {}", c.shutter_close, c.shutter_open));
    check.require(!look.output.denoise || look.output.samples > 1, "look.output.denoise",
                  "\"denoise\" needs 2 samples a pixel at least", "write for example samples: 8");
    for (const Appearance& a : look.appearances) {
        const std::string path = "look.appearances." + a.name;
        for (std::size_t k = 1; k < a.colour_map.size(); ++k)
            check.require(
                a.colour_map[k].at > a.colour_map[k - 1].at, fmt::format("{}.colour_map.{}.at", path, k),
                fmt::format("\"at\" must ascend: {} is not above {}", a.colour_map[k].at, a.colour_map[k - 1].at));
        check_glow(a, path, check);
        const bool mapped = a.colour_by == ColourBy::temperature || a.colour_by == ColourBy::speed;
        check.require(!mapped || !a.colour_map.empty(), path + ".colour_by", "\"colour_by\" needs a \"colour_map\"",
                      "for example colour_map: [{at: 0, colour: [0, 0, 1]}, {at: 100, colour: [1, 0, 0]}]");
        check.require(a.image.file.empty() || (a.colour_by == ColourBy::none && a.checker == 0), path + ".image",
                      "an image takes the place of \"colour\": it goes with neither \"checker\" nor \"colour_by\"");
        check.require(a.image.file.empty() || a.type != AppearanceType::dielectric, path + ".image",
                      "a dielectric has no colour that an image could give; its colour is \"absorption\"");
        for (const Appearance& inside : look.appearances)
            check.require(a.inside != inside.name ||
                              (a.type == AppearanceType::dielectric) == (inside.type == AppearanceType::dielectric),
                          path + ".inside", "one side of a crack lets light through and the other does not",
                          "make both a dielectric, or none");
    }
    for (const Light& l : look.lights) check_light(l, look, check);
}

void check_wearers(const Scene& scene, const Checker& check) {
    const auto require = [&](bool has, const std::string& given, const std::string& own, const std::string& wearer) {
        const std::string& appearance = given.empty() ? own : given;
        for (const Appearance& a : scene.look.appearances)
            check.require(has || a.name != appearance || a.image.file.empty() || a.image.mapping != Mapping::uv,
                          "look.appearances." + a.name + ".image.mapping",
                          fmt::format("{} has no texture coordinates to map the image by", wearer),
                          "write mapping: planar, box or cylinder");
    };
    const auto require_matter = [&](const std::string& material, const std::string& wearer) {
        for (const Material& m : scene.materials)
            if (m.name == material) require(false, m.look, m.name, wearer);
    };
    for (const Body& b : scene.bodies) {
        const std::string wearer = fmt::format("the body \"{}\", made of surfels,", b.name);
        b.look.empty() ? require_matter(b.material, wearer) : require(false, b.look, b.look, wearer);
    }
    for (const Emitter& e : scene.emitters)
        require_matter(e.material, fmt::format("what the emitter \"{}\" releases", e.name));
    for (const Boundary& b : scene.world.boundaries) {
        std::set<std::string> seen;
        const std::string wearer = fmt::format("the boundary \"{}\"", b.name);
        if (b.visible) check_temperatures(scene, b.look.empty() ? b.name : b.look, wearer, check);
        if (b.visible) require(holds_mesh(scene, b.shape, seen), b.look, b.name, wearer + ", no mesh,");
    }
}

}  // namespace thixo::scene
