// The cache of a simulation: a folder that is enough to render from. Format: docs/cache_format.md.
//
//     CacheWriter writer = CacheWriter::create(out, {scene.name, resolved_text, simulation_hash});
//     frame.obstacles[0].asset = writer.add_asset(ply_bytes);
//     writer.write_frame(frame);            // files, then manifest; each whole
//     writer.finish();
//
//     CacheReader reader(out);
//     for (int n : reader.frames()) render(reader.load_frame(n));
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/contract/frame.h"
#include "pipeline/contract/manifest.h"

namespace thixo {

/// What a cache is made from.
struct CacheIdentity {
    std::string scene;            // name
    std::string scene_text;       // resolved scene; render reads its look from here
    std::string simulation_hash;  // of the blocks the simulation reads
};

/// The bytes of a file that the manifest of this cache folder lists. Throws CacheError where they are not those listed.
std::string read_listed(const std::filesystem::path& folder, const CacheFile& file);
/// Whether they are. Where not, is_sound tells why by a warning, and is_whole is silent.
bool is_whole(const std::filesystem::path& folder, const CacheFile& file);
bool is_sound(const std::filesystem::path& folder, const CacheFile& file);

/// Writes out/cache. Every file is written whole (atomic_file.h), a frame's files before the manifest that lists them.
/// Two kinds of files are changed or removed: those that the manifest lists, and those that a killed run left, as their
/// content shows (ownership.h). Where another program's file has a name that a cache needs, members throw InputError.
/// All members throw ResourceError when the disk is full or read-only. What the manifest listed before is then still
/// there and still listed.
class CacheWriter {
  public:
    /// An empty cache. Throws InputError where out/cache already has a manifest.
    static CacheWriter create(const std::filesystem::path& out, CacheIdentity identity);
    /// An empty cache in place of the one that may be there.
    static CacheWriter restart(const std::filesystem::path& out, CacheIdentity identity);
    /// Goes on with the cache that is there: keeps frames up to and with `last_kept` (CacheReader::last_sound), drops
    /// later ones (they will be written again). A complete cache of the same resolved scene, all kept, stays complete
    /// and is not written to. Throws CacheError (missing, damaged) and InputError where its simulation hash is another.
    static CacheWriter resume(const std::filesystem::path& out, CacheIdentity identity, int last_kept);

    /// Adds the frame, or replaces the one of that number. `frame.particles` and `frame.surfels` need "P" where they
    /// have points. Throws DivergedError where a value is not finite, naming attribute and point.
    void write_frame(const Frame& frame);
    /// Stores the bytes once as assets/<hash><extension>, listed from the next frame on. Stores them again where the
    /// listed file is missing or damaged. Returns the hash.
    std::string add_asset(std::string_view bytes, std::string_view extension = kAssetExtensions[0]);
    /// Throws CacheError where a listed asset is missing or damaged and this run has not stored it again.
    void require_assets() const;
    /// Marks the cache complete.
    void finish();

    const Manifest& manifest() const { return manifest_; }

  private:
    CacheWriter(const std::filesystem::path& out, Manifest manifest);
    static CacheWriter open(const std::filesystem::path& out, const Manifest& before, Manifest manifest,
                            bool unchanged);
    void publish();
    void need_format(int format);
    CacheFile store(const std::string& name, std::string_view bytes);

    std::filesystem::path folder_;
    Manifest manifest_;
};

/// Reads a cache, also one that a running simulation still extends. Every file's size and checksum are verified before
/// it is parsed; all members throw CacheError with one line that names the file.
class CacheReader {
  public:
    /// `path`: an output folder, its cache folder, or a manifest.json.
    explicit CacheReader(const std::filesystem::path& path);

    /// True where CacheReader(path) would find a manifest.
    static bool exists(const std::filesystem::path& path);
    /// Reads the manifest again; true where it changed (new frames, or complete).
    bool refresh();

    const Manifest& manifest() const { return manifest_; }
    const std::filesystem::path& folder() const { return folder_; }
    std::vector<int> frames() const;
    /// Reads frames first, first + 1, ... as long as they are there undamaged: the last of them, or first - 1. A
    /// damaged file is told as a warning.
    int last_sound(int first) const;
    /// Reads frames first to last and every asset: whether all are there undamaged. Tells nothing: who mends the cache
    /// tells what was damaged, and once.
    bool is_whole(int first, int last) const;
    bool has_frame(int number) const { return manifest_.find(number) != nullptr; }
    bool complete() const { return manifest_.complete; }
    const std::string& scene_text() const { return manifest_.scene_text; }

    /// Everything of a frame. Points come in voxel order, each with its own attributes; "P" comes first.
    Frame load_frame(int number) const;
    /// Everything but the points.
    Frame load_facts(int number) const;
    PointSet load_particles(int number) const;
    PointSet load_surfels(int number) const;
    /// Whether the manifest lists an asset of this hash.
    bool has_asset(std::string_view hash) const;
    /// The bytes of the asset of this hash.
    std::string load_asset(std::string_view hash) const;

  private:
    const ManifestFrame& entry(int number) const;
    std::string verified(const CacheFile& file) const;

    std::filesystem::path folder_;
    Manifest manifest_;
};

}  // namespace thixo
