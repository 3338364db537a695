#include <algorithm>
#include <system_error>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/vdb_points.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

/// The cache folder `path` means: itself, its cache/, or where the manifest lies; empty where there is none.
fs::path cache_folder(const fs::path& path) {
    std::error_code ignored;
    if (path.filename() == kManifestName && fs::exists(fs::symlink_status(path, ignored)))
        return path.has_parent_path() ? path.parent_path() : fs::path(".");
    for (const fs::path& folder : {path, path / "cache"})
        if (fs::exists(fs::symlink_status(folder / kManifestName, ignored))) return folder;
    return {};
}

Manifest read_manifest(const fs::path& folder) {
    return parse_manifest(read_inside(folder, kManifestName, kLargestManifest), (folder / kManifestName).string());
}

void require_count(std::size_t found, std::uint64_t listed, const fs::path& file) {
    if (found != listed)
        throw CacheError("'{}' is damaged: it holds {} points, the manifest says {}", file.string(), found, listed);
}

}  // namespace

std::string read_listed(const fs::path& folder, const CacheFile& file) {
    std::string bytes = read_inside(folder, file.name, file.size);
    if (bytes.size() != file.size || hash_hex(bytes) != file.hash)
        throw CacheError("'{}' is damaged: its checksum does not match the manifest; simulate again",
                         (folder / file.name).string());
    return bytes;
}

bool is_whole(const fs::path& folder, const CacheFile& file) {
    try {
        read_listed(folder, file);
        return true;
    } catch (const CacheError&) {
        return false;
    }
}

bool is_sound(const fs::path& folder, const CacheFile& file) {
    try {
        read_listed(folder, file);
        return true;
    } catch (const CacheError& e) {
        log_warning("{}", e.what());
        return false;
    }
}

CacheReader::CacheReader(const fs::path& path) : folder_(cache_folder(path)) {
    if (folder_.empty())
        throw CacheError("no cache in '{}': it has no manifest.json; simulate first with 'thixo sim'", path.string());
    manifest_ = read_manifest(folder_);
}

bool CacheReader::exists(const fs::path& path) { return !cache_folder(path).empty(); }

bool CacheReader::refresh() {
    Manifest now = read_manifest(folder_);
    if (now == manifest_) return false;
    manifest_ = std::move(now);
    return true;
}

std::vector<int> CacheReader::frames() const {
    std::vector<int> numbers;
    for (const ManifestFrame& f : manifest_.frames) numbers.push_back(f.number);
    return numbers;
}

const ManifestFrame& CacheReader::entry(int number) const {
    const ManifestFrame* f = manifest_.find(number);
    if (!f) throw CacheError("the cache '{}' has no frame {}; simulate it with 'thixo sim'", folder_.string(), number);
    return *f;
}

std::string CacheReader::verified(const CacheFile& file) const { return read_listed(folder_, file); }

int CacheReader::last_sound(int first) const {
    const auto sound = [&](const CacheFile* file) { return is_sound(folder_, *file); };
    int number = first;
    for (const ManifestFrame* f = manifest_.find(number); f && std::ranges::all_of(f->files(), sound);
         f = manifest_.find(number))
        ++number;
    return number - 1;
}

bool CacheReader::is_whole(int first, int last) const {
    const auto whole = [&](const CacheFile& file) { return thixo::is_whole(folder_, file); };
    for (int number = first; number <= last; ++number) {
        const ManifestFrame* f = manifest_.find(number);
        if (!f ||
            !std::ranges::all_of(f->files(), whole, [](const CacheFile* file) -> const CacheFile& { return *file; }))
            return false;
    }
    return std::ranges::all_of(manifest_.assets, whole);
}

Frame CacheReader::load_facts(int number) const {
    const ManifestFrame& f = entry(number);
    const std::string file = (folder_ / f.facts_file.name).string();
    Frame frame = parse_frame_facts(verified(f.facts_file), file);
    if (frame.number != number) throw CacheError("'{}' is damaged: it holds frame {}", file, frame.number);
    return frame;
}

PointSet CacheReader::load_particles(int number) const {
    const ManifestFrame& f = entry(number);
    const fs::path file = folder_ / f.particle_file.name;
    PointSet points = decode_points(verified(f.particle_file), file.string());
    require_count(points.count, f.particles, file);
    return points;
}

PointSet CacheReader::load_surfels(int number) const {
    const ManifestFrame& f = entry(number);
    const fs::path file = folder_ / f.surfel_file.name;
    PointSet points = decode_points(verified(f.surfel_file), file.string());
    require_count(points.count, f.surfels, file);
    return points;
}

Frame CacheReader::load_frame(int number) const {
    Frame frame = load_facts(number);
    frame.particles = load_particles(number);
    frame.surfels = load_surfels(number);
    return frame;
}

bool CacheReader::has_asset(std::string_view hash) const {
    return std::any_of(manifest_.assets.begin(), manifest_.assets.end(),
                       [&](const CacheFile& a) { return a.hash == hash; });
}

std::string CacheReader::load_asset(std::string_view hash) const {
    for (const CacheFile& a : manifest_.assets)
        if (a.hash == hash) return verified(a);
    throw CacheError("the cache '{}' has no asset '{}'; simulate again with --restart", folder_.string(), hash);
}

}  // namespace thixo
