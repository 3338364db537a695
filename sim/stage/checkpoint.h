// The exact state of a run on disk, so that a killed run continues with the same bytes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/loop/simulation.h"

namespace thixo {

/// Format of a checkpoint, apart from the program's version. A checkpoint of another format or of the other precision
/// is not read. The run then starts from an earlier one, or from the beginning, and gives the same frames.
inline constexpr std::uint32_t kCheckpointFormat = 10;

/// Everything that a later step depends on: clock, ids, emitters, every array of particles and surface, bit for bit.
std::string print_checkpoint(const Simulation& sim, const std::string& simulation_hash);

/// Restores a simulation that make_simulation has made from the same scene. Throws CacheError, naming `file` and what
/// is wrong: damaged, other format, other precision or scene, or no state of this scene (checkpoint_check.h). The
/// simulation is then as it was.
void parse_checkpoint(std::string_view bytes, const std::string& file, const std::string& simulation_hash,
                      Simulation& sim);

/// Writes out/checkpoint/checkpoint.NNNN.bin. Keeps it and the one before it; removes older ones, and those of later
/// frames, which the run will pass again. Throws ResourceError.
void write_checkpoint(const std::filesystem::path& out, int frame, std::string_view bytes);

/// Frames that have a checkpoint file, newest first.
std::vector<int> list_checkpoints(const std::filesystem::path& out);

/// Restores the newest readable checkpoint of frame <= last. False where there is none. One that is refused gets the
/// name refused.NNNN.K.bin, with a warning, and is not read again.
bool restore_checkpoint(const std::filesystem::path& out, int last, const std::string& simulation_hash,
                        Simulation& sim);

/// Removes the checkpoints; what has the name of one and is none gets the name refused.NNNN.K.bin.
void remove_checkpoints(const std::filesystem::path& out);

}  // namespace thixo
