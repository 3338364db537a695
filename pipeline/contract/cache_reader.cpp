#include <algorithm>
#include <system_error>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/vdb_points.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

constexpr const char* kManifestName = "manifest.json";

/// The cache folder `path` means: itself, its cache/, or where the manifest lies; empty where there is none.
fs::path cache_folder(const fs::path& path) {
    std::error_code ignored;
    if (path.filename() == kManifestName && fs::is_regular_file(path, ignored))
        return path.has_parent_path() ? path.parent_path() : fs::path(".");
    for (const fs::path& folder : {path, path / "cache"})
        if (fs::is_regular_file(folder / kManifestName, ignored)) return folder;
    return {};
}

Manifest read_manifest(const fs::path& folder) {
    const fs::path file = folder / kManifestName;
    return parse_manifest(read_whole(file), file.string());
}

void require_count(std::size_t found, std::uint64_t listed, const fs::path& file) {
    if (found != listed)
        throw CacheError("'{}' is damaged: it holds {} points, the manifest says {}", file.string(), found, listed);
}

}  // namespace

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

std::string CacheReader::verified(const CacheFile& file) const {
    const fs::path path = folder_ / file.name;
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    // The size first: a file grown by damage is not even read.
    if (!error && size != file.size)
        throw CacheError("'{}' is damaged: it has {} bytes, the manifest says {}; simulate again with --restart",
                         path.string(), size, file.size);
    std::string bytes = read_whole(path);
    if (bytes.size() != file.size || hash_hex(bytes) != file.hash)
        throw CacheError("'{}' is damaged: its checksum does not match the manifest; simulate again with --restart",
                         path.string());
    return bytes;
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
