// The tree of a scene file with all that it extends, and the overrides of the command line.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/contract/scene_problems.h"
#include "pipeline/contract/scene_value.h"

namespace thixo::scene {

/// The tree of a source, laid over the trees of the files that `extends` names. These names are relative to the
/// source's folder. The files may extend others; a cycle is a problem. With follow = false `extends` stays in the tree,
/// where the reader does not know it. Nothing is returned where a file could not be turned into a tree.
std::optional<Value> read_tree(int source, Problems& problems, bool follow = true);

/// read_tree of a file that the command line names.
std::optional<Value> read_tree_file(const std::string& path, Problems& problems);

/// Sets "key.path=value" in the tree. The value is YAML. A number within the path is a place in a list, from 0.
void apply_override(Value& tree, const std::string& text, Problems& problems);

}  // namespace thixo::scene
