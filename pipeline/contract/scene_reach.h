// Which files a scene may have opened: a scene may come from a stranger.
#pragma once

#include <string>

#include "pipeline/contract/scene_problems.h"

namespace thixo::scene {

/// Folders that every scene may read from, separated by colons.
inline constexpr const char* kReachVariable = "THIXO_FILES";

/// Whether the file `path`, which the text at `from` names, may be opened; where not, a problem is noted.
///
/// - What `--set` names may be opened: it is the user's own word.
/// - What a scene or a look names or extends must lie below the folder of the file that the user named. A folder of
///   THIXO_FILES will do as well.
///
/// Links are followed before this is decided.
bool may_open(const std::string& path, const Position& from, Problems& problems);

}  // namespace thixo::scene
