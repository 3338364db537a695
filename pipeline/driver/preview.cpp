#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/ownership.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"
#include "pipeline/driver/scratch_folder.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

constexpr const char* kScratch = "preview";

RenderArgs preview_args(const Command& command, const Job& job) {
    RenderArgs args = render_args(command, job);
    args.preview = true;
    args.what = command.what.empty() ? "auto" : command.what;
    args.attribute = command.attribute;
    return args;
}

int print_files(const Command& command, const std::vector<std::string>& files) {
    if (command.json) print_json(nlohmann::ordered_json{{"files", files}});
    if (!command.json && !command.quiet)
        for (const std::string& file : files) fmt::print("{}\n", file);
    return kDone;
}

std::vector<fs::path> pictures(const fs::path& folder) {
    std::vector<fs::path> found;
    std::error_code missing;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, missing))
        if (entry.path().extension() == ".png") found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
}

/// The scene's first instant, made in a folder of its own: a cache beside it stays as it is.
int preview_scene(const Command& command, const Job& job) {
    if (!command.frames.empty())
        throw InputError(
            "--frames goes with a cache; the preview of a scene shows its first instant, nothing is simulated");
    Job aside = job;
    aside.out = temporary_path(job.out, kScratch);
    SimArgs sim = sim_args(command, aside);
    sim.initial = true;
    sim.quiet = true;
    RenderArgs render = preview_args(command, aside);
    render.quiet = true;
    const ProgramCall calls[] = {stage_call("thixo-sim", sim.print()), stage_call("thixo-render", render.print())};
    if (command.dry_run) return print_calls({calls[0], calls[1]});

    const ScratchFolder scratch(job.out, kScratch);
    for (const ProgramCall& call : calls)
        if (const int code = run_to_end(call); code != kDone) return code;
    const fs::path kept = make_subfolder(job.out, "preview");
    std::vector<std::string> files;
    for (const fs::path& picture : pictures(aside.out / "preview")) {
        require_own(kept / picture.filename(), is_own_png);
        fs::rename(picture, kept / picture.filename());
        files.push_back((kept / picture.filename()).string());
    }
    return print_files(command, files);
}

int preview_cache(const Command& command, const Job& job) {
    const ProgramCall call = stage_call("thixo-render", preview_args(command, job).print());
    if (command.dry_run) return print_calls({call});
    if (const int code = run_to_end(call); code != kDone) return code;
    return print_files(command, {(job.out / "preview").string()});
}

}  // namespace

int preview_verb(const Command& command) {
    const Job job = scene_or_cache_job(command);
    return job.scene ? preview_scene(command, job) : preview_cache(command, job);
}

}  // namespace thixo
