// The list at the end of a run: what it could not do of what its scene says.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/contract/shortfall.h"
#include "pipeline/driver/command.h"

namespace thixo {

/// Exit code with --strict where a run could not do all that its scene says; beside those of pipeline/base/error.h.
inline constexpr int kFellShort = 6;

/// Prints the list to stderr, a warning a line. Returns kFellShort where it is not empty and --strict is given.
int tell_shortfalls(const std::vector<Shortfall>& list, const Command& command);

/// What a cache says of the run that made it; nothing where there is none.
std::vector<Shortfall> shortfalls_in(const std::filesystem::path& out);

}  // namespace thixo
