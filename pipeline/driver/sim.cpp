#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/contract/shortfall_json.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/fell_short.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"

namespace thixo {

int sim_verb(const Command& command) {
    const Job job = scene_job(command);
    const ProgramCall call = stage_call("thixo-sim", sim_args(command, job).print());
    if (command.dry_run) return print_calls({call});
    const int code = run_to_end(call);
    if (code != kDone) return code;
    const std::string cache = (job.out / "cache").string();
    const std::vector<Shortfall> list = shortfalls_in(job.out);
    if (command.json)
        print_json(nlohmann::ordered_json{{"cache", cache}, {"shortfalls", shortfalls_json(list)}});
    else if (!command.quiet)
        fmt::print("{}\n", cache);
    return tell_shortfalls(list, command);
}

}  // namespace thixo
