#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"

namespace thixo {

int relight_verb(const Command& command) {
    const Job job = render_job(command);
    RenderArgs args = render_args(command, job);
    args.relight = true;
    const ProgramCall call = stage_call("thixo-render", args.print());
    if (command.dry_run) return print_calls({call});
    const int code = run_to_end(call);
    const std::filesystem::path root = job.pictures.empty() ? job.out : job.pictures;
    const std::string frames =
        command.look.empty() ? (root / kRelitFrames).string() : frames_folder(root, command.look).string();
    if (code == kDone && command.json) print_json(nlohmann::ordered_json{{"frames", frames}});
    if (code == kDone && !command.json && !command.quiet) fmt::print("{}\n", frames);
    return code;
}

}  // namespace thixo
