#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/machine_memory.h"
#include "pipeline/contract/picture_cost.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/shortfall_json.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/fell_short.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"

namespace thixo {
namespace {

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
        parsed.at("shortfalls");
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
    nlohmann::ordered_json needs = estimate(command, job, code);
    if (code != kDone) return code;
    const std::vector<Shortfall> shortfalls = parse_shortfalls(needs["shortfalls"], "thixo-sim --estimate");
    // A run simulates and renders at once.
    const scene::PictureCost pictures = scene::picture_cost(job.scene->look, nullptr);
    const double frames = job.scene->frames.last - job.scene->frames.first + 1;
    const double memory = needs["memory"].get<double>() + pictures.memory;
    needs["memory"] = std::llround(memory);
    needs["picture_disk"] = std::llround(pictures.disk_per_frame * frames);
    if (memory > machine_memory())
        log_warning("this needs about {} of memory, and this machine has {}", bytes_text(memory),
                    bytes_text(machine_memory()));
    const int strict = tell_shortfalls(shortfalls, command);
    if (command.json) {
        nlohmann::ordered_json result{{"scene", job.scene->name}, {"warnings", warnings}};
        result.update(needs);
        print_json(result);
    } else {
        fmt::print("{}: {}; about {} particles, {} of memory, {} on disk and {} of pictures\n", command.path,
                   shortfalls.empty() ? "no problems" : "falls short", needs["particles"].get<std::int64_t>(),
                   bytes_text(memory), bytes_text(needs["disk"]), bytes_text(needs["picture_disk"]));
        if (needs.contains("crack_surfels"))
            fmt::print(
                "  It can break. How often, and where, is not known before. Counted is a cut across each body that "
                "can: "
                "about {} surfels. Each further cut adds as many, up to {} where all is shattered\n",
                needs["crack_surfels"].get<std::int64_t>(), needs["crack_surfels_most"].get<std::int64_t>());
    }
    return strict;
}

}  // namespace thixo
