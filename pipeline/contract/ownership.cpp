#include "pipeline/contract/ownership.h"

#include <fmt/core.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/frame.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/manifest.h"
#include "pipeline/contract/vdb_points.h"

namespace thixo {
namespace fs = std::filesystem;

IsOwn own_cache_file(std::string_view name) {
    if (is_asset_file_name(name))  // named by its checksum
        return [name = std::string(name)](std::string_view bytes) { return fs::path(name).stem() == hash_hex(bytes); };
    const std::optional<FrameFileName> file = parse_frame_file_name(name);
    if (!file) return {};
    return file->kind == FrameFileName::facts ? is_own_facts : is_own_points;
}

bool is_foreign(const fs::path& path, const IsOwn& is_own) {
    std::error_code failure;
    const fs::file_status status = fs::symlink_status(path, failure);
    if (status.type() == fs::file_type::not_found) return false;
    if (!fs::is_regular_file(status)) return true;
    const std::string bytes = read_whole(path);
    return !bytes.empty() && !is_own(bytes);
}

void require_none_foreign(const std::vector<fs::path>& foreign) {
    constexpr std::size_t kShown = 5;
    if (foreign.empty()) return;
    std::string names;
    for (std::size_t k = 0; k < std::min(foreign.size(), kShown); ++k)
        names += fmt::format("{}'{}'", k > 0 ? ", " : "", foreign[k].string());
    if (foreign.size() > kShown) names += fmt::format(" and {} more", foreign.size() - kShown);
    throw InputError("{} {} not written by Thixo and would be overwritten; move {}, or give --out for another folder",
                     names, foreign.size() > 1 ? "were" : "was", foreign.size() > 1 ? "them" : "it");
}

void require_own(const fs::path& path, const IsOwn& is_own) {
    if (is_foreign(path, is_own)) require_none_foreign({path});
}

}  // namespace thixo
