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

Manifest empty_manifest(CacheIdentity identity) {
    Manifest m;
    m.scene = std::move(identity.scene);
    m.scene_text = std::move(identity.scene_text);
    m.simulation_hash = std::move(identity.simulation_hash);
    return m;
}

bool is_frame_file(const std::string& name) {
    return (name.starts_with("particles.") && name.ends_with(".vdb")) ||
           (name.starts_with("surfels.") && name.ends_with(".vdb")) ||
           (name.starts_with("frame.") && name.ends_with(".json"));
}

bool is_asset_file(const std::string& name) {
    return std::any_of(kAssetExtensions.begin(), kAssetExtensions.end(),
                       [&](std::string_view extension) { return name.ends_with(extension); });
}

bool lists(const Manifest& m, const std::string& name) {
    const auto named = [&](const CacheFile& f) { return f.name == name; };
    return std::any_of(m.assets.begin(), m.assets.end(), named) ||
           std::any_of(m.frames.begin(), m.frames.end(), [&](const ManifestFrame& f) {
               return named(f.particle_file) || named(f.surfel_file) || named(f.facts_file);
           });
}

/// Removes cache files that the manifest does not list: of dropped frames, and of a frame that was being written when a
/// run was killed. Nothing that a cache would not write itself is touched.
void remove_unlisted(const fs::path& folder, const Manifest& m) {
    std::vector<fs::path> unlisted;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        const std::string name = it->path().filename().string();
        if (is_frame_file(name) && !lists(m, name)) unlisted.push_back(it->path());
    }
    for (fs::directory_iterator it(folder / "assets", error), end; !error && it != end; it.increment(error)) {
        const std::string name = it->path().filename().string();
        if (is_asset_file(name) && !lists(m, "assets/" + name)) unlisted.push_back(it->path());
    }
    for (const fs::path& path : unlisted) {
        fs::remove(path, error);
        if (error) throw ResourceError("cannot remove '{}': {}", path.string(), error.message());
    }
}

/// Frames that are kept must still be there: a run that continues must not end in a cache with holes.
void require_files(const fs::path& folder, const Manifest& m) {
    const auto require = [&](const CacheFile& f) {
        std::error_code error;
        const std::uintmax_t size = fs::file_size(folder / f.name, error);
        if (error) throw CacheError("'{}' is missing; simulate again with --restart", (folder / f.name).string());
        if (size != f.size)
            throw CacheError("'{}' is damaged: it has {} bytes, the manifest says {}; simulate again with --restart",
                             (folder / f.name).string(), size, f.size);
    };
    for (const CacheFile& a : m.assets) require(a);
    for (const ManifestFrame& f : m.frames)
        for (const CacheFile* file : {&f.particle_file, &f.surfel_file, &f.facts_file}) require(*file);
}

}  // namespace

CacheWriter::CacheWriter(const fs::path& out, Manifest manifest)
    : folder_(out / "cache"), manifest_(std::move(manifest)) {}

CacheWriter CacheWriter::open(const fs::path& out, Manifest manifest, bool unchanged) {
    CacheWriter writer(out, std::move(manifest));
    make_folder(writer.folder_ / "assets");
    remove_stale_temporaries(writer.folder_);
    remove_stale_temporaries(writer.folder_ / "assets");
    if (!unchanged) writer.publish();
    remove_unlisted(writer.folder_, writer.manifest_);
    return writer;
}

CacheWriter CacheWriter::create(const fs::path& out, CacheIdentity identity) {
    if (CacheReader::exists(out / "cache"))
        throw InputError("'{}' holds a cache already; choose another folder with --out, or replace it with --restart",
                         out.string());
    return open(out, empty_manifest(std::move(identity)), false);
}

CacheWriter CacheWriter::restart(const fs::path& out, CacheIdentity identity) {
    return open(out, empty_manifest(std::move(identity)), false);
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
    return open(out, std::move(m), unchanged);
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
    publish();
}

std::string CacheWriter::add_asset(std::string_view bytes, std::string_view extension) {
    CacheFile file{"", bytes.size(), hash_hex(bytes)};
    file.name = asset_file_name(file.hash, extension);
    auto& assets = manifest_.assets;
    const auto at = std::lower_bound(assets.begin(), assets.end(), file.name,
                                     [](const CacheFile& f, const std::string& n) { return f.name < n; });
    if (at != assets.end() && at->name == file.name) return file.hash;
    std::string hash = file.hash;
    write_whole(folder_ / file.name, bytes);
    assets.insert(at, std::move(file));
    if (extension != kAssetExtensions[0]) manifest_.format = 2;
    return hash;
}

void CacheWriter::finish() {
    manifest_.complete = true;
    publish();
}

}  // namespace thixo
