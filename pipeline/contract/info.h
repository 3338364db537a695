// What `thixo info` says of a cache, a frame, a picture. (Of a scene: scene.h.)
#pragma once

#include <filesystem>
#include <string>

namespace thixo {

/// True where describe() knows the path: a cache (folder, out folder, manifest.json), one of its files (.vdb,
/// frame.NNNN.json), an .exr.
bool describes(const std::filesystem::path& path);

/// Text for a person, or (json) one JSON document, both ending in a newline:
/// of a cache {"scene", "format", "complete", "frames": [{"frame", "time", "particles", "surfels", "bodies", "air",
/// "virtual", "mass" [kg], "momentum" [kg m/s], "energy" [J] kinetic + potential, "volume" [m^3] enclosed by the
/// surfels or, without surfels, of the particles, "sha"}]}; of a frame one such object and "attributes" {name: {"type",
/// "min", "mean", "max"}}; of an EXR size, channels, header text. Throws CacheError: missing, damaged, not a file of a
/// cache.
std::string describe(const std::filesystem::path& path, bool json);

}  // namespace thixo
