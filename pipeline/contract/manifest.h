// manifest.json: what a cache holds, with every file's size and checksum. Format: docs/cache_format.md.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace thixo {

/// The newest format this program writes; it reads 1 to this. Apart from the program's version.
inline constexpr int kCacheFormat = 4;
inline constexpr int kLargestFrameNumber = 999'999;
inline constexpr const char* kManifestName = "manifest.json";
inline constexpr std::uint64_t kLargestManifest = std::uint64_t(1)
                                                  << 29;  // bytes: all frames there can be, and a scene

struct CacheFile {
    std::string name;        // relative to the cache folder
    std::uint64_t size = 0;  // bytes
    std::string hash;        // hash_hex of the file

    bool operator==(const CacheFile&) const = default;
};

struct ManifestFrame {
    int number = 0;
    double time = 0;                           // s
    std::uint64_t particles = 0, surfels = 0;  // counts
    CacheFile particle_file, surfel_file, facts_file;

    bool operator==(const ManifestFrame&) const = default;
    std::array<const CacheFile*, 3> files() const { return {&particle_file, &surfel_file, &facts_file}; }
    /// One checksum for the frame: of its files' checksums.
    std::string hash() const;
};

struct Manifest {
    int format = 1;                     // the earliest that has all of this (cache_format.md)
    std::string scene;                  // name
    std::string simulation_hash;        // of what the simulation reads of the scene
    bool complete = false;              // the simulation reached its last frame
    std::string scene_text;             // the resolved scene, every default written out
    std::vector<CacheFile> assets;      // assets/<hash>.<extension>, ascending by name
    std::vector<ManifestFrame> frames;  // ascending by number, no duplicates

    bool operator==(const Manifest&) const = default;
    const ManifestFrame* find(int number) const;
    bool lists(std::string_view name) const;  // relative to the cache folder
    std::uint64_t bytes() const;              // of all frame files and assets
};

/// Names within the cache folder.
std::string particle_file_name(int frame);  // particles.0001.vdb
std::string surfel_file_name(int frame);    // surfels.0001.vdb
std::string facts_file_name(int frame);     // frame.0001.json

/// A file of a frame by its name; nothing where no frame has a file of this name.
struct FrameFileName {
    enum Kind { particles, surfels, facts } kind;
    int frame;
};
std::optional<FrameFileName> parse_frame_file_name(std::string_view name);

inline constexpr const char* kAssetFolder = "assets";
/// What an asset is: a mesh, or an image of the look.
inline constexpr std::array<std::string_view, 5> kAssetExtensions{".ply", ".exr", ".png", ".hdr", ".jpg"};
/// How many of them a format has.
constexpr std::size_t asset_kinds(int format) { return format < 2 ? 1 : format < 4 ? 3 : kAssetExtensions.size(); }
/// assets/<hash><extension>
std::string asset_file_name(std::string_view hash, std::string_view extension = kAssetExtensions[0]);

/// Whether `name` is assets/<32 hexadecimal digits><one of kAssetExtensions>.
bool is_asset_file_name(std::string_view name);

/// JSON with a fixed layout and key order; its first key is a checksum of the rest.
std::string print_manifest(const Manifest& manifest);

/// Parses and checks everything; `file` is named in messages. Throws CacheError: damaged, of a newer format, or
/// contradictory.
Manifest parse_manifest(std::string_view text, const std::string& file);

}  // namespace thixo
