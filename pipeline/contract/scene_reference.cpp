#include "pipeline/contract/scene_reference.h"

#include <fmt/format.h>

#include <cctype>

#include "pipeline/contract/scene_describe.h"
#include "pipeline/contract/scene_reader.h"

namespace thixo::scene {
namespace {

constexpr const char* kIntroduction = R"(# The scene file

This page is made from the declarations of the keys in `pipeline/contract/scene_*.h`; a test fails when it is stale.
Rewrite it with `THIXO_UPDATE_DOCS=1` set for that test. Editors check scenes against `docs/scene.schema.json`.

A scene is one YAML file in UTF-8. Units are SI, temperatures degrees Celsius, z points up, colours are linear Rec.709 as [r, g, b].
Every key that is left out has the default given here; `thixo validate SCENE --print` shows a scene with all of them. A small scene:

```yaml
frames: {last: 48}
materials:
  water: {viscosity: 0.05}
bodies:
  drop: {material: water, shape: {sphere: {radius: 0.1}, translate: [0, 0, 0.5]}}
world:
  boundaries:
    floor: {shape: {plane: {offset: 0}}}
solver: {spacing: 0.02}
look:
  camera: {position: [0, -2, 0.6], look_at: [0, 0, 0.2]}
```

**Named lists** (`materials`, `bodies`, `emitters`, `world.boundaries`, `shapes`, `look.lights`, `look.appearances`) are maps from a name to a
block, and their order is kept. A name has letters, digits, `_` and `-`.

**extends.** `extends: other.yaml` at the top takes another scene, relative to this file, and lays this one over it by name: blocks and named
lists merge key by key, lists and single values are replaced. In a shape another kind replaces the kind. Chains are allowed.

**Files** that a scene names (`extends`, meshes, images) lie in its own folder or below. Links are followed before that is decided. The environment
variable `THIXO_FILES` lists further folders, separated by colons: `THIXO_FILES=$HOME/models:$HOME/textures`. What `--set` names may lie anywhere.

**Look files.** `--look FILE` lays a file with a block `look`, or with a look's keys directly, over the scene's look in the same way: one with only
lights keeps camera and appearances. A light is taken out by `strength: 0`.

**--set key.path=value** sets one key, named by its path: `--set materials.water.viscosity=1`. The value is YAML: `--set
"world.gravity=[0, 0, -1.62]"`. A number in the path is a place in a list, from 0. A name that the scene does not have is an error.

**--draft** doubles `solver.spacing`, halves `look.output.width` and `height`, and takes a quarter of the samples (at least 4). Its
pictures are denoised.

**Glow.** An appearance with `glow: {strength: 3, black_body: 1100}` gives light by the temperature of its matter, as lava does. At 1100 degC its luminance is
3; at 900 degC it is a twentieth of that, and redder. The same light leaves to all sides: from bodies outwards, from meshes on both sides, through clear coats
undimmed. Paths find it where they meet it. So large things that glow light others well, while what is small and bright makes noise. More samples, `denoise`,
or a lamp in its place help then.

**Numbers** are decimal: `0.01`, `1e-3`. Where no end of a range is written it is -1e12 or 1e12. What YAML readers disagree about is refused: `017`, `0x1F`, `1_000`, `.inf`, `yes`.
**Errors** are all told at once, each as file:line:column with the line and a caret. Files may have up to 4 MiB, 200 000 values (aliases counted
in full) and 64 levels.
)";

const char* type_text(const KeyInfo& key) {
    using Type = KeyInfo::Type;
    switch (key.type) {
        case Type::number:
            return "number";
        case Type::whole:
            return "whole number";
        case Type::truth:
            return "true or false";
        case Type::text:
            return "text";
        case Type::word:
            return "word";
        case Type::vector2:
            return "[x, y]";
        case Type::vector3:
            return "[x, y, z]";
        case Type::colour:
            return "[r, g, b]";
        case Type::profile:
            return "list of [r, z]";
        case Type::reference:
            return "name";
        case Type::file:
            return "path";
        case Type::block:
            return "block";
        case Type::named:
            return "named blocks";
        case Type::list:
            return "list of blocks";
        case Type::shape:
            return "[shape](#shapes-and-their-kinds)";
        case Type::shapes:
            return "list of [shapes](#shapes-and-their-kinds)";
        case Type::named_shapes:
            return "named [shapes](#shapes-and-their-kinds)";
    }
    return "";
}

std::string default_text(const KeyInfo& key) {
    if (key.check.required) return "**required**";
    if (key.default_value.type == Value::Type::null) return "";
    std::string text = print_value(key.default_value);
    text.pop_back();
    return text == "\"\"" || text == "[]" ? "" : "`" + text + "`";
}

std::string range_text(const KeyInfo& key) {
    return key.type == KeyInfo::Type::word ? fmt::format("`{}`", fmt::join(key.words, "`, `")) : describe(key.check);
}

void add_table(const std::vector<KeyInfo>& keys, std::string& out) {
    out += "\n| key | type | default | unit | range | meaning |\n|---|---|---|---|---|---|\n";
    for (const KeyInfo& key : keys)
        out += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.name, type_text(key), default_text(key),
                           key.unit == kColour ? "" : key.unit, range_text(key), key.meaning);
}

bool is_value(const KeyInfo& key) { return key.type < KeyInfo::Type::block; }

// A section for every block, outer ones first.
void add_sections(const KeyInfo& key, const std::string& path, int level, std::string& out) {
    if (key.keys.empty()) return;
    const bool is_named = key.type == KeyInfo::Type::named, is_list = key.type == KeyInfo::Type::list;
    out += fmt::format(
        "\n{} {}{}\n\n{}.\n", std::string(static_cast<std::size_t>(level), '#'), path,
        is_named  ? ".*name*"
        : is_list ? ".*number*"
                  : "",
        static_cast<char>(std::toupper(static_cast<unsigned char>(key.meaning[0]))) + key.meaning.substr(1));
    if (key.name == "motion") {
        out += "Keys as in [motion](#motion).\n";
        return;
    }
    add_table(key.keys, out);
    for (const KeyInfo& inner : key.keys)
        if (!is_value(inner) && inner.name != "motion") add_sections(inner, path + "." + inner.name, level + 1, out);
}

}  // namespace

std::string scene_reference() {
    std::string out = kIntroduction;
    const std::vector<KeyInfo> scene = describe_scene();
    out += "\n## The blocks\n";
    add_table(scene, out);
    for (const KeyInfo& block : scene) add_sections(block, block.name, 2, out);
    out +=
        "\n## motion\n\nA list of instants. Between them the motion is smooth and turns the shorter way, at most 180 "
        "degrees from one to the next; before the first and after the last it rests.\n";
    add_table(Describer::keys_of<Key>(), out);
    out +=
        "\n## Shapes and their kinds\n\nA shape is a block with one key that names its kind, and modifiers beside it: "
        "`{box: {size: [1, 1, 1]}, rotate: [0, 0, 45], translate: [0, 0, 1]}`.\n"
        "Modifiers:\n";
    add_table(describe_shape_modifiers(), out);
    for (const ShapeKindInfo& kind : describe_shape_kinds()) {
        out += fmt::format("\n### {}\n\n{}{}.", kind.name,
                           static_cast<char>(std::toupper(static_cast<unsigned char>(kind.meaning[0]))),
                           kind.meaning.substr(1));
        if (!kind.short_key.empty())
            out += fmt::format(" In short `{}: ...` for `{}: {{{}: ...}}`.", kind.name, kind.name, kind.short_key);
        out += "\n";
        add_table(kind.keys, out);
    }
    return out;
}

}  // namespace thixo::scene
