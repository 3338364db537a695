// What `thixo info` says of a cache, a frame, a picture. (Of a scene: scene.h.)
#pragma once

#include <filesystem>
#include <string>

namespace thixo {

/// True where describe() knows the path: a cache (folder, out folder, manifest.json), one of its files (.vdb,
/// frame.NNNN.json), an .exr.
bool describes(const std::filesystem::path& path);

/// Text for a person, or (json) one JSON document. Both end in a newline. The document of a cache is
///
///     {"scene", "format", "complete", "frames": [FRAME, ...], "shortfalls": [...]}
///
/// and of a frame FRAME with one more member, "attributes": {name: {"type", "min", "mean", "max"}}. FRAME is
///
///     {"frame", "time", "particles", "surfels", "bodies", "air", "virtual",
///      "mass" [kg], "momentum" [kg m/s], "energy" [J], "volume" [m^3], "sha"}
///
/// The list of shortfalls is that of shortfalls_json. The energy is kinetic + potential. The volume is what the surfels enclose, or without surfels that of the particles.
/// The document of an EXR holds size, channels and header text. Throws CacheError where the path is missing, damaged,
/// or no file of a cache.
std::string describe(const std::filesystem::path& path, bool json);

}  // namespace thixo
