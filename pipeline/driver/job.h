// From the command's words to what the stages get: the scene, the output folder, the calls.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/contract/scene.h"
#include "pipeline/contract/stage_args.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/process.h"

namespace thixo {

/// A scene or a cache, and where its output is.
struct Job {
    std::optional<scene::Scene> scene;  // empty: a cache was named
    std::filesystem::path out;          // output folder
    std::filesystem::path pictures;     // where frames/ goes; empty: to `out`
};

/// Reads the scene the command names. Throws InputError (all its problems).
Job scene_job(const Command& command);
/// The output folder of the cache the command names. Throws InputError (no such folder), CacheError (no cache in it).
Job cache_job(const Command& command);
/// Whichever it is.
Job scene_or_cache_job(const Command& command);
/// Whichever it is; the frames of a cache may go to a folder of their own (--out).
Job render_job(const Command& command);
/// Whichever it is, but the cache may be damaged: a folder is enough. Throws InputError where there is none.
Job output_job(const Command& command);

/// ./out/<name>, a draft's ./out/<name>.draft.
std::filesystem::path default_out(const std::string& scene_name, bool draft);
/// <out>/frames, with a look file <out>/frames.<stem of the file>.
std::filesystem::path frames_folder(const std::filesystem::path& out, const std::string& look_file);
/// Those that `relight` mixes without a look file.
inline constexpr const char* kRelitFrames = "frames.relit";
/// <out>/<name>.mp4, with a look file <out>/<name>.<stem of the file>.mp4; or with another ending.
std::filesystem::path film_file(const std::filesystem::path& out, const std::string& scene_name,
                                const std::string& look_file, const std::string& ending = ".mp4");

SimArgs sim_args(const Command& command, const Job& job);
RenderArgs render_args(const Command& command, const Job& job);

/// The program beside the running one, or in the folder that the environment variable THIXO_BIN names.
ProgramCall stage_call(const std::string& name, std::vector<std::string> args);

/// --dry-run: the calls on stdout, one a line.
int print_calls(const std::vector<ProgramCall>& calls);

}  // namespace thixo
