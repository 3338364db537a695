#include "pipeline/contract/scene_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "pipeline/contract/look_images.h"
#include "pipeline/contract/scene_build.h"
#include "pipeline/contract/scene_check.h"
#include "pipeline/contract/scene_defaults.h"
#include "pipeline/contract/scene_extent.h"
#include "pipeline/contract/scene_problems.h"
#include "pipeline/contract/scene_reader.h"
#include "pipeline/contract/scene_tree.h"
#include "pipeline/contract/scene_walk.h"

namespace thixo::scene {
namespace {

Position start_of(const Value& tree) { return {tree.at.source, 0, 0, 1}; }

Scene read_scene(std::optional<Value> tree, const std::string& name, const std::vector<std::string>& overrides,
                 Files files, Problems& problems) {
    const std::string what = "scene " + shown(name, kPathShown);
    if (tree && tree->type != Value::Type::map && tree->type != Value::Type::null) {
        problems.add(
            tree->at, fmt::format("a scene must be a map of blocks, not {}", describe(*tree)),
            tree->text.find(':') != std::string::npos && !tree->quoted ? "a blank is missing behind the colon" : "");
        tree.reset();
    }
    if (tree && tree->type == Value::Type::null) {
        problems.add(start_of(*tree), "the file is empty", "a scene is a map of blocks: materials, bodies, look, ...");
        tree.reset();
    }
    if (!tree) problems.throw_if_any(what);
    for (const std::string& text : overrides) apply_override(*tree, text, problems);
    Scene scene;
    ReadContext context{problems, files, {}};
    BlockReader reader(*tree, "", start_of(*tree), context);
    visit(reader, scene);
    reader.report_unknown("extends");
    settle_defaults(scene, context.where);
    check_scene(scene, context);
    if (files == Files::check) read_file_hashes(scene, context);
    read_image_hashes(scene.look, context);
    problems.throw_if_any(what);
    fill_in(scene, name, context.where);
    return scene;
}

// A look file's keys, whether in a block `look` or on their own.
std::optional<Value> look_block(std::optional<Value> tree, Problems& problems) {
    if (!tree || tree->type != Value::Type::map || !tree->find("look")) return tree;
    for (const Label& label : tree->labels)
        if (label.text != "look")
            problems.add(label.at, fmt::format("a look file holds nothing beside the block \"look\", but has \"{}\"",
                                               shown(label.text)));
    return *tree->find("look");
}

/// Lights that nobody asked for go once a look names lights of its own, and all go where it says that there are none.
void remove_replaced_lights(const Look& base, const Value& over, Value& tree) {
    const Value* named = over.find("lights");
    Value* lights = tree.find("lights");
    if (!named || named->type != Value::Type::map || !lights) return;
    for (const Light& l : base.lights)
        if (named->items.empty() || (is_default_light(l) && !named->find(l.name))) lights->remove(l.name);
}

}  // namespace

Scene load_scene(const std::string& path, const std::vector<std::string>& overrides, bool draft) {
    Problems problems;
    Scene scene = read_scene(read_tree_file(path, problems), path, overrides, Files::check, problems);
    if (draft) apply_draft(scene);
    return scene;
}

Scene parse_scene(const std::string& text, const std::string& name, const std::vector<std::string>& overrides,
                  Files files) {
    Problems problems;
    const int source = problems.add_source({name, std::filesystem::path(name).parent_path().string(), text});
    return read_scene(read_tree(source, problems, files == Files::check), name, overrides, files, problems);
}

std::string print_scene(const Scene& scene) { return print_value(to_block(scene)); }

std::string print_cached_scene(const Scene& scene) {
    Scene cached = scene;
    walk_shapes(cached, [](Shape& shape, const std::string&) {
        if (MeshFile* mesh = std::get_if<MeshFile>(&shape.kind)) mesh->file = mesh->content;
    });
    for (Body& b : cached.bodies)
        for (PaintedCrack& c : b.cracks) c.image.file = c.image.content;
    for_each_image(cached.look,
                   [](const std::string&, ImageUse, std::string& file, const std::string& content) { file = content; });
    return print_scene(cached);
}

Scene parse_cached_scene(const std::string& text, const std::string& name, const std::vector<std::string>& overrides) {
    const Scene stored = parse_scene(text, name, {}, Files::ignore);
    return parse_scene(print_cached_scene(stored), name, overrides, Files::ignore);
}

std::string print_look(const Look& look) { return print_value(to_block(look)); }

Look overlay_look(const Look& base, const std::string& path, const std::vector<std::string>& overrides) {
    const std::string what = path.empty() ? "look" : "look " + shown(path, kPathShown);
    Problems problems;
    Value tree = to_block(base);
    if (!path.empty()) {
        const std::optional<Value> over = look_block(read_tree_file(path, problems), problems);
        if (over && over->type != Value::Type::map)
            problems.add(over->at, fmt::format("a look must be a map of blocks, not {}", describe(*over)));
        problems.throw_if_any(what);
        remove_replaced_lights(base, *over, tree);
        std::vector<std::string> labels{"look"};
        overlay(tree, *over, labels);
    }
    Value whole;
    whole.at_label({"look", {}}) = std::move(tree);
    for (const std::string& text : overrides)
        if (text.starts_with("look.")) apply_override(whole, text, problems);
    Look look;
    ReadContext context{problems, Files::check, {}};
    BlockReader reader(whole, "", {}, context);
    reader.block("look", look, "");
    check_look(look, context);
    read_image_hashes(look, context);
    problems.throw_if_any(what);
    return look;
}

void apply_draft(Scene& scene) {
    scene.solver.spacing *= 2;
    apply_draft(scene.look);
}

void apply_draft(Look& look) {
    Output& o = look.output;
    o.width = std::max(1, o.width / 2);
    o.height = std::max(1, o.height / 2);
    o.samples = std::min(o.samples, std::max(4, o.samples / 4));
    o.denoise = o.samples > 1;
}

std::vector<std::string> scene_warnings(const Scene& scene) {
    std::vector<std::string> warnings;
    const auto warn = [&]<class... A>(fmt::format_string<A...> f, A&&... a) {
        warnings.push_back(fmt::format(f, std::forward<A>(a)...));
    };
    std::set<std::string> materials, appearances;
    for (const Body& b : scene.bodies) {
        materials.insert(b.material);
        appearances.insert(b.look);
    }
    for (const Emitter& e : scene.emitters) materials.insert(e.material);
    for (const Material& m : scene.materials)
        for (const MaterialChange& c : m.elastic.changes) materials.insert(c.material);
    for (const Material& m : scene.materials) {
        appearances.insert(m.look);
        if (!materials.count(m.name)) warn("materials.{} is not used by any body or emitter", m.name);
    }
    for (const Boundary& b : scene.world.boundaries) appearances.insert(b.look);
    for (const Appearance& a : scene.look.appearances) appearances.insert(a.inside);
    for (const Appearance& a : scene.look.appearances)
        if (!appearances.count(a.name)) warn("look.appearances.{} is not used by any material or boundary", a.name);
    if (scene.bodies.empty() && scene.emitters.empty())
        warn("the scene has neither bodies nor emitters: nothing will move");
    const double end = (scene.frames.last - scene.frames.first) / scene.frames.fps;
    for (const Emitter& e : scene.emitters) {
        if (e.radius < scene.solver.spacing)
            warn("emitters.{}.radius {} m is below solver.spacing {} m: the flow is a single row of particles", e.name,
                 e.radius, scene.solver.spacing);
        if (e.start >= end && scene.frames.last > scene.frames.first)
            warn("emitters.{} starts at {} s, after the last frame at {:.4g} s", e.name, e.start, end);
    }
    if (const std::optional<Extent> matter = extent_of_matter(scene, nullptr)) {
        // Half the last bit of a float of this size is a 128th of a spacing.
        constexpr double kMost = 131072;
        const double half = 0.5 * (matter->upper - matter->lower).maxCoeff() / scene.solver.spacing;
        if (half > kMost)
            warn(
                "bodies and emitters stand up to {:.3g} spacings from their middle, where single precision holds "
                "places to {:.2g} spacings; raise solver.spacing, or make a scene of each part",
                half, std::ldexp(1.0, std::ilogb(half) - 24));
    }
    for (const Light& l : scene.look.lights)
        if (l.type == LightType::area && l.size.maxCoeff() > 0 && l.strength == 0)
            warn("look.lights.{} has the strength 0", l.name);
    for (std::string& idle : idle_keys(scene)) warnings.push_back(std::move(idle));
    return warnings;
}

}  // namespace thixo::scene
