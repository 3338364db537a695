// Scenes and looks from and to text.
#pragma once

#include <string>
#include <vector>

#include "pipeline/contract/scene.h"

namespace thixo::scene {

/// Whether the files a scene names (meshes, `extends`) are looked at. `ignore` is for a scene that a cache carries: it
/// is whole, and the files may be gone.
enum class Files { check, ignore };

/// Reads a scene file with what it extends, applies the overrides ("key.path=value", in order) and, last, the draft.
/// Throws InputError naming every problem as file:line:column with the line and a caret; the first line counts them.
Scene load_scene(const std::string& path, const std::vector<std::string>& overrides = {}, bool draft = false);

/// The same from text; `name` stands for the file in messages, and relative paths start from its folder (with
/// Files::ignore they stay).
Scene parse_scene(const std::string& text, const std::string& name, const std::vector<std::string>& overrides = {},
                  Files files = Files::check);

/// The scene as YAML with every key, default or not. parse_scene(print_scene(s), name, {}, Files::ignore) gives the
/// same scene.
std::string print_scene(const Scene& scene);
std::string print_look(const Look& look);

/// The scene as a cache carries it: print_scene with every file it names called by its content's checksum alone. So the
/// text is the same wherever the scene lies, tells nothing of the user's folders, and leads to no file.
std::string print_cached_scene(const Scene& scene);
/// The scene of such a text, and of one by an earlier version, whose paths are no longer followed. Overrides may name
/// files of today. `name` stands for the cache in messages. Throws InputError.
Scene parse_cached_scene(const std::string& text, const std::string& name,
                         const std::vector<std::string>& overrides = {});

/// A look file laid over a look by name: what the file does not mention stays. Default lights go where it names lights,
/// and all lights where it says `lights: {}`. The file holds a block `look`, or a
/// look's keys directly. Of the overrides those of look.* apply, after the file. An empty path: the overrides alone.
/// Throws InputError as load_scene does.
Look overlay_look(const Look& base, const std::string& path, const std::vector<std::string>& overrides = {});

/// Twice the spacing, half the resolution, a quarter of the samples but not below 4 (or what there were).
void apply_draft(Scene& scene);
void apply_draft(Look& look);

/// What is allowed but probably not meant, one line each: unused materials, an emitter thinner than a particle, and the
/// like. Then come idle_keys.
std::vector<std::string> scene_warnings(const Scene& scene);

/// Keys that were given another value than their default, and do nothing with the solvers chosen, one line each. What
/// mixes liquids that should stay apart is told too.
std::vector<std::string> idle_keys(const Scene& scene);

}  // namespace thixo::scene
