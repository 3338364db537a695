// The scene file's documentation, made from the declarations of its keys.
#pragma once

#include <string>

namespace thixo::scene {

/// docs/scene.md
std::string scene_reference();

/// docs/scene.schema.json, a JSON Schema (draft 2020-12) for editors
std::string scene_schema();

}  // namespace thixo::scene
