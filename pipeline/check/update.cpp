#include "pipeline/check/update.h"

#include <algorithm>
#include <system_error>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"

namespace thixo {

namespace fs = std::filesystem;

namespace {

void copy_file(const fs::path& from, const fs::path& to, const std::string& name, Update& update) {
    const std::string bytes = read_whole(from);
    std::error_code ignored;
    const bool there = fs::is_regular_file(to, ignored);
    if (there && read_whole(to) == bytes) return;
    if (to.has_parent_path()) make_folder(to.parent_path());
    write_whole(to, bytes);
    (there ? update.replaced : update.added).push_back(name);
}

void remove_file(const fs::path& path, const std::string& name, Update& update) {
    std::error_code failure;
    fs::remove(path, failure);
    if (failure) throw ResourceError("'{}' cannot be removed: {}", path.string(), failure.message());
    update.removed.push_back(name);
}

std::vector<std::string> files_of(const Manifest& manifest) {
    std::vector<std::string> names;
    for (const CacheFile& f : manifest.assets) names.push_back(f.name);
    for (const ManifestFrame& f : manifest.frames)
        for (const CacheFile* file : {&f.particle_file, &f.surfel_file, &f.facts_file})
            if (!file->name.empty()) names.push_back(file->name);
    std::sort(names.begin(), names.end());
    return names;
}

}  // namespace

Update update_pictures(const fs::path& a, const std::vector<std::string>& names_a, const fs::path& b,
                       const std::vector<std::string>& names_b) {
    Update update;
    for (const std::string& name : names_a) copy_file(a / name, b / name, name, update);
    for (const std::string& name : names_b)
        if (!std::binary_search(names_a.begin(), names_a.end(), name)) remove_file(b / name, name, update);
    return update;
}

Update update_picture(const fs::path& a, const fs::path& b) {
    Update update;
    copy_file(a, b, b.string(), update);
    return update;
}

Update update_cache(const fs::path& a, const fs::path& b) {
    const CacheReader from(a);
    std::vector<std::string> old_names;
    // A new reference gets the layout of A: an output folder holds its cache in cache/.
    fs::path folder = from.folder().lexically_normal() == fs::path(a).lexically_normal() ? b : b / "cache";
    if (CacheReader::exists(b)) {
        const CacheReader to(b);
        folder = to.folder();
        old_names = files_of(to.manifest());
    }
    Update update;
    const std::vector<std::string> names = files_of(from.manifest());
    for (const std::string& name : names) copy_file(from.folder() / name, folder / name, name, update);
    copy_file(from.folder() / "manifest.json", folder / "manifest.json", "manifest.json", update);
    for (const std::string& name : old_names)
        if (!std::binary_search(names.begin(), names.end(), name)) remove_file(folder / name, name, update);
    return update;
}

}  // namespace thixo
