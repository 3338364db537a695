// Every file of an output folder against its checksum.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/driver/command.h"

namespace thixo {

/// What is wrong with a file, and how it can be had again.
struct Damage {
    enum class Part { manifest, cache, checkpoint, pictures, film } part;
    std::filesystem::path file;
    std::string problem;
    std::string remedy;
    int frame = -1;  // of a picture
};

struct VerifyReport {
    std::size_t files = 0;  // looked at
    std::vector<Damage> damages;
};

/// Reads the manifest and all that it lists, the checkpoints, the pictures of every frames folder, and the films. What
/// is not there and not listed is no damage, but for the PNG of an EXR and the EXR of a PNG. Throws only where a folder
/// cannot be listed.
VerifyReport verify_output(const std::filesystem::path& out);

/// Prints the report and returns the exit code: 4 where something is damaged.
int report_damages(const std::filesystem::path& out, const VerifyReport& report, const Command& command);

}  // namespace thixo
