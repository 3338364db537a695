// YAML text to a Value tree. The only place that knows the YAML library.
#pragma once

#include <optional>
#include <string>

#include "pipeline/contract/scene_problems.h"
#include "pipeline/contract/scene_value.h"

namespace thixo::scene {

/// Limits against files made to exhaust memory or time.
inline constexpr std::size_t kLargestSceneFile = 4 << 20;  // bytes
inline constexpr std::size_t kMostValues = 200'000;        // aliases written out
inline constexpr std::size_t kMostKeys = 10'000;           // of one block
inline constexpr std::size_t kDeepest = 64;                // blocks and lists in each other

/// The tree of the source's text; nothing where no tree could be made. What it refuses becomes a problem: duplicate
/// keys, tags, aliases that contain themselves, text that is not UTF-8, a second document, a syntax error.
std::optional<Value> read_yaml(int source, Problems& problems);

/// Reads a file into a new source and returns its number. Where the file is missing, no regular file, unreadable or too
/// large, that becomes a problem at `from`, the place that names it.
std::optional<int> open_source(const std::string& path, const Position& from, Problems& problems);

}  // namespace thixo::scene
