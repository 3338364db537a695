#include <fmt/core.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/ownership.h"
#include "pipeline/contract/vdb_points.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

Manifest empty_manifest(CacheIdentity identity) {
    Manifest m;
    m.scene = std::move(identity.scene);
    m.scene_text = std::move(identity.scene_text);
    m.simulation_hash = std::move(identity.simulation_hash);
    return m;
}

/// Files with names that a cache can have but `now` does not list. Own ones are to be removed; foreign ones are another
/// program's.
struct Leftovers {
    std::vector<fs::path> own, foreign;
};

/// A file is the cache's own where `before`, the manifest that was there, lists it, or where its content proves it. A
/// run that was killed within a frame leaves files that no manifest lists. Files with other names are left alone.
Leftovers find_leftovers(const fs::path& folder, const Manifest& before, const Manifest& now) {
    Leftovers found;
    const auto look_at = [&](const fs::path& path, const std::string& name) {
        const IsOwn is_own = own_cache_file(name);
        if (!is_own || now.lists(name)) return;
        (before.lists(name) || !is_foreign(path, is_own) ? found.own : found.foreign).push_back(path);
    };
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        look_at(it->path(), it->path().filename().string());
    for (fs::directory_iterator it(folder / kAssetFolder, error), end; !error && it != end; it.increment(error))
        look_at(it->path(), fmt::format("{}/{}", kAssetFolder, it->path().filename().string()));
    return found;
}

void remove_all_of(const std::vector<fs::path>& paths) {
    for (const fs::path& path : paths) {
        std::error_code error;
        fs::remove(path, error);
        if (error) throw ResourceError("cannot remove '{}': {}", path.string(), error.message());
    }
}

/// Frames that are kept must still be there: a run that continues must not end in a cache with holes.
void require_files(const fs::path& folder, const Manifest& m) {
    for (const ManifestFrame& f : m.frames)
        for (const CacheFile* file : f.files()) {
            std::error_code missing;
            if (fs::file_size(folder / file->name, missing) != file->size)
                throw CacheError("'{}' is missing or damaged; simulate again", (folder / file->name).string());
        }
}

}  // namespace

CacheWriter::CacheWriter(const fs::path& out, Manifest manifest)
    : folder_(out / "cache"), manifest_(std::move(manifest)) {}

CacheWriter CacheWriter::open(const fs::path& out, const Manifest& before, Manifest manifest, bool unchanged) {
    CacheWriter writer(out, std::move(manifest));
    make_subfolder(out, fs::path("cache") / kAssetFolder);
    const Leftovers leftovers = find_leftovers(writer.folder_, before, writer.manifest_);
    require_none_foreign(leftovers.foreign);
    remove_stale_temporaries(writer.folder_);
    remove_stale_temporaries(writer.folder_ / kAssetFolder);
    if (!unchanged) writer.publish();
    remove_all_of(leftovers.own);
    return writer;
}

CacheWriter CacheWriter::create(const fs::path& out, CacheIdentity identity) {
    if (CacheReader::exists(out / "cache"))
        throw InputError("'{}' holds a cache already; choose another folder with --out, or replace it with --restart",
                         out.string());
    return open(out, {}, empty_manifest(std::move(identity)), false);
}

CacheWriter CacheWriter::restart(const fs::path& out, CacheIdentity identity) {
    Manifest before;
    try {
        if (CacheReader::exists(out / "cache")) before = CacheReader(out / "cache").manifest();
    } catch (const CacheError& e) {
        log_warning("{}; it is replaced", e.what());  // only their content then tells which files were the cache's
    }
    return open(out, before, empty_manifest(std::move(identity)), false);
}

CacheWriter CacheWriter::resume(const fs::path& out, CacheIdentity identity, int last_kept) {
    const Manifest old = CacheReader(out / "cache").manifest();
    if (old.simulation_hash != identity.simulation_hash)
        throw InputError(
            "'{}' holds the cache of another simulation; choose another folder with --out, or replace it with "
            "--restart",
            out.string());
    Manifest m = empty_manifest(std::move(identity));
    m.assets = old.assets;
    m.format = old.format;
    for (const ManifestFrame& f : old.frames)
        if (f.number <= last_kept) m.frames.push_back(f);
    require_files(out / "cache", m);
    // A cache that needs nothing more stays complete, and is not written to.
    m.complete = old.complete && m.scene_text == old.scene_text && m.frames.size() == old.frames.size();
    const bool unchanged = m == old;
    return open(out, old, std::move(m), unchanged);
}

void CacheWriter::publish() { write_whole(folder_ / kManifestName, print_manifest(manifest_)); }

CacheFile CacheWriter::store(const std::string& name, std::string_view bytes) {
    write_whole(folder_ / name, bytes);
    return {name, bytes.size(), hash_hex(bytes)};
}

void CacheWriter::write_frame(const Frame& frame) {
    THIXO_ASSERT(frame.number >= 0 && frame.number <= kLargestFrameNumber, "frame {}", frame.number);
    THIXO_ASSERT(frame.spacing > 0, "frame {} has spacing {}", frame.number, frame.spacing);
    const double voxel = voxel_size_for(frame.spacing);
    // All three are encoded before the first is written: a frame that cannot be encoded leaves no trace.
    const std::string particles = encode_points(frame.particles, "particles", voxel);
    const std::string surfels = encode_points(frame.surfels, "surfels", voxel);
    const std::string facts = print_frame_facts(frame);

    ManifestFrame entry;
    entry.number = frame.number;
    entry.time = frame.time;
    entry.particles = frame.particles.count;
    entry.surfels = frame.surfels.count;
    entry.particle_file = store(particle_file_name(frame.number), particles);
    entry.surfel_file = store(surfel_file_name(frame.number), surfels);
    entry.facts_file = store(facts_file_name(frame.number), facts);

    auto& frames = manifest_.frames;
    const auto at = std::lower_bound(frames.begin(), frames.end(), frame.number,
                                     [](const ManifestFrame& f, int n) { return f.number < n; });
    if (at != frames.end() && at->number == frame.number)
        *at = std::move(entry);
    else
        frames.insert(at, std::move(entry));
    manifest_.complete = false;
    if (!frame.particles.origin.isZero() || !frame.surfels.origin.isZero()) need_format(3);
    publish();
}

void CacheWriter::need_format(int format) { manifest_.format = std::max(manifest_.format, format); }

std::string CacheWriter::add_asset(std::string_view bytes, std::string_view extension) {
    CacheFile file{"", bytes.size(), hash_hex(bytes)};
    file.name = asset_file_name(file.hash, extension);
    auto& assets = manifest_.assets;
    const auto at = std::lower_bound(assets.begin(), assets.end(), file.name,
                                     [](const CacheFile& f, const std::string& n) { return f.name < n; });
    const bool listed = at != assets.end() && at->name == file.name;
    if (listed && is_sound(folder_, file)) return file.hash;
    std::string hash = file.hash;
    write_whole(folder_ / file.name, bytes);
    if (listed) return hash;
    assets.insert(at, std::move(file));
    const auto kind = std::find(kAssetExtensions.begin(), kAssetExtensions.end(), extension) - kAssetExtensions.begin();
    int format = 1;
    while (format < kCacheFormat && asset_kinds(format) <= static_cast<std::size_t>(kind)) ++format;
    need_format(format);
    return hash;
}

void CacheWriter::require_assets() const {
    for (const CacheFile& asset : manifest_.assets) read_listed(folder_, asset);
}

void CacheWriter::finish() {
    manifest_.complete = true;
    publish();
}

}  // namespace thixo
