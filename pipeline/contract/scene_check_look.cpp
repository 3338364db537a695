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
    for (const Light& l : look.lights) {
        check.require(l.group.empty() || is_name(l.group), "look.lights." + l.name + ".group",
                      fmt::format("\"{}\" is no name of a group", l.group), "letters, digits, _ and -, at most 64");
        check.require(!look.output.passes.lights || group_of(l) != kBackgroundGroup, "look.lights." + l.name,
                      fmt::format("the group \"{}\" is that of look.background", kBackgroundGroup),
                      "write another group");
    }
    for (const Light& l : look.lights)
        check.require(l.type != LightType::environment || !l.file.empty(), "look.lights." + l.name,
                      fmt::format("the environment \"{}\" needs a \"file\"", l.name), "an EXR, twice as wide as high");
}

void check_texture_coordinates(const Scene& scene, const Checker& check) {
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
        if (b.visible)
            require(holds_mesh(scene, b.shape, seen), b.look, b.name,
                    fmt::format("the boundary \"{}\", no mesh,", b.name));
    }
}

}  // namespace thixo::scene
