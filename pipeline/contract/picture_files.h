// Finished pictures on disk: their names, what they were made from, and whether they are whole.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/contract/image.h"

namespace thixo {

/// Header attribute: what the light of a picture depends on.
inline constexpr const char* kLightsKey = "thixo.lights";

/// What a picture's bytes depend on; stated in the EXR's header.
struct PictureIdentity {
    std::string scene;  // name
    std::string look;   // hash of look, appearance names and seed
    std::string cache;  // hash of the cached frame
    int frame = 0;
    double time = 0;  // s
    int samples = 0;
};

std::filesystem::path exr_path(const std::filesystem::path& folder, int frame);  // beauty.0001.exr
std::filesystem::path png_path(const std::filesystem::path& folder, int frame);  // beauty.0001.png

/// What is on disk of a picture.
struct StoredPicture {
    std::string problem;      // what is missing or damaged, and of which file; empty: both files are whole
    bool exr_there = false;   // and whole
    std::string look, cache;  // as the EXR states them
    std::string lights;       // kLightsKey; empty: a picture of an earlier version
};
/// Reads both files: the EXR has its checksum, the PNG is the one whose checksum the EXR states.
StoredPicture read_picture(const std::filesystem::path& folder, int frame);

enum class PictureState {
    absent,     // or damaged, or made from another cache frame, or the PNG is not the one of the EXR: to be rendered
    done,       // both there, of this look and this cache frame
    other_look  // there, of another look
};
PictureState picture_state(const std::filesystem::path& folder, const PictureIdentity& identity);

/// Throws InputError where the EXR or the PNG of this frame is there and another program's.
void require_own_picture(const std::filesystem::path& folder, int frame);

/// Writes the PNG, then the EXR with the identity and the PNG's checksum in its header: where the EXR is, both are.
/// Throws ResourceError.
void write_picture(const std::filesystem::path& folder, const PictureIdentity& identity, Image image,
                   const Image8& display);

}  // namespace thixo
