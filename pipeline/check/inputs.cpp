#include "pipeline/check/inputs.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "pipeline/base/error.h"
#include "pipeline/contract/cache.h"

namespace thixo {

namespace fs = std::filesystem;

CheckKind check_kind(const fs::path& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored))
        throw CacheError("'{}' is not there; name a frame folder, a cache or an EXR picture", path.string());
    if (CacheReader::exists(path)) return CheckKind::cache;
    if (fs::is_directory(path, ignored)) {
        if (picture_names(path, nullptr).empty())
            throw CacheError("'{}' holds neither a cache (manifest.json) nor pictures (*.exr); name a folder that does",
                             path.string());
        return CheckKind::folder;
    }
    if (path.extension() == ".exr") return CheckKind::picture;
    throw InputError("'{}' is no EXR picture, no frame folder and no cache", path.string());
}

const char* name_of(CheckKind kind) {
    return kind == CheckKind::cache ? "a cache" : kind == CheckKind::folder ? "a frame folder" : "a picture";
}

int frame_number_of(const std::string& file_name) {
    const std::string stem = fs::path(file_name).stem().string();
    const std::size_t dot = stem.rfind('.');
    const char *begin = stem.data() + (dot == std::string::npos ? 0 : dot + 1), *end = stem.data() + stem.size();
    int number = -1;
    const auto [stop, failure] = std::from_chars(begin, end, number);
    return failure == std::errc() && stop == end && number >= 0 ? number : -1;
}

std::vector<std::string> picture_names(const fs::path& folder, const std::vector<int>* frames) {
    std::vector<std::string> names;
    std::error_code failure;
    for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end; entry.increment(failure)) {
        const std::string name = entry->path().filename().string();
        if (entry->path().extension() != ".exr" || name.front() == '.') continue;
        if (frames && !std::binary_search(frames->begin(), frames->end(), frame_number_of(name))) continue;
        names.push_back(name);
    }
    if (failure && fs::exists(folder))
        throw CacheError("'{}' cannot be listed: {}", folder.string(), failure.message());
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::string> picture_folders(const fs::path& path) {
    std::vector<std::string> names;
    std::error_code failure;
    if (!fs::exists(path / "cache" / kManifestName, failure)) return names;
    for (fs::directory_iterator entry(path, failure), end; !failure && entry != end; entry.increment(failure)) {
        const std::string name = entry->path().filename().string();
        if ((name == "frames" || name.starts_with("frames.")) && !picture_names(entry->path(), nullptr).empty())
            names.push_back(name);
    }
    if (failure) throw CacheError("'{}' cannot be listed: {}", path.string(), failure.message());
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace thixo
