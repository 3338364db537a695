#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"

namespace thixo {

int render_verb(const Command& command) {
    const Job job = scene_or_cache_job(command);
    const ProgramCall call = stage_call("thixo-render", render_args(command, job).print());
    if (command.dry_run) return print_calls({call});
    const int code = run_to_end(call);
    const std::string frames = frames_folder(job.out, command.look).string();
    if (code == kDone && command.json) print_json(nlohmann::ordered_json{{"frames", frames}});
    if (code == kDone && !command.json && !command.quiet) fmt::print("{}\n", frames);
    return code;
}

}  // namespace thixo
