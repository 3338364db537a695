#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/job.h"

namespace thixo {
namespace {

std::string bytes_text(double bytes) {
    return bytes < 1e6   ? fmt::format("{:.0f} kB", bytes / 1e3)
           : bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6)
                         : fmt::format("{:.1f} GB", bytes / 1e9);
}

/// What thixo-sim --estimate says: {"particles": n, "memory": bytes, "disk": bytes}.
nlohmann::ordered_json estimate(const Command& command, const Job& job, int& code) {
    SimArgs args = sim_args(command, job);
    args.estimate = true;
    std::string text;
    code = run_to_end(stage_call("thixo-sim", args.print()), &text);
    if (code != kDone) return {};
    try {
        nlohmann::ordered_json parsed = nlohmann::ordered_json::parse(text);
        for (const char* key : {"particles", "memory", "disk"}) parsed.at(key).get<double>();
        return parsed;
    } catch (const nlohmann::json::exception& e) {
        throw InputError("thixo-sim --estimate answers in another form than this program expects ({}); build both anew",
                         e.what());
    }
}

}  // namespace

int validate_verb(const Command& command) {
    const Job job = scene_job(command);  // throws with all problems at once
    if (command.print) {
        fmt::print("{}", scene::print_scene(*job.scene));
        return kDone;
    }
    const std::vector<std::string> warnings = scene::scene_warnings(*job.scene);
    for (const std::string& warning : warnings) log_warning("{}", warning);
    int code = kDone;
    const nlohmann::ordered_json needs = estimate(command, job, code);
    if (code != kDone) return code;
    if (command.json) {
        nlohmann::ordered_json result{{"scene", job.scene->name}, {"warnings", warnings}};
        result.update(needs);
        fmt::print("{}\n", result.dump());
    } else {
        fmt::print("{}: no problems; about {} particles, {} of memory, {} on disk\n", command.path,
                   needs["particles"].get<std::int64_t>(), bytes_text(needs["memory"]), bytes_text(needs["disk"]));
    }
    return kDone;
}

}  // namespace thixo
