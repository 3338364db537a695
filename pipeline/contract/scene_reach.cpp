#include "pipeline/contract/scene_reach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string_view>

namespace thixo::scene {
namespace {

namespace fs = std::filesystem;

/// The path without links, "." and ".."; what does not exist is taken as it is written.
fs::path real(const fs::path& path) {
    std::error_code failure;
    const fs::path found = fs::weakly_canonical(fs::absolute(path, failure), failure);
    return failure ? fs::path() : found;
}

bool is_below(const fs::path& file, const fs::path& folder) {
    return !file.empty() && !folder.empty() &&
           std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

bool user_allows(const fs::path& file) {
    const char* const set = std::getenv(kReachVariable);
    for (std::string_view rest = set ? set : ""; !rest.empty();) {
        const std::size_t end = std::min(rest.find(':'), rest.size());
        if (end > 0 && is_below(file, real(rest.substr(0, end)))) return true;
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return false;
}

}  // namespace

bool may_open(const std::string& path, const Position& from, Problems& problems) {
    if (problems.source(from.source).is_override) return true;
    const std::string& named = problems.source(0).folder;  // the first text is the file that the user named
    const fs::path folder = real(named.empty() ? "." : named), file = real(path);
    if (is_below(file, folder) || user_allows(file)) return true;
    problems.add(from,
                 fmt::format("{} lies outside of the scene's folder {}", shown(path, kPathShown),
                             shown(folder.string(), kPathShown)),
                 fmt::format("copy it there, or allow its folder: {}={}", kReachVariable,
                             shown(file.parent_path().string(), kPathShown)));
    return false;
}

}  // namespace thixo::scene
