#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/shortfall_json.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/conduct.h"
#include "pipeline/driver/fell_short.h"
#include "pipeline/driver/film.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"
#include "pipeline/driver/verify.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

void print_result(const Command& command, const Job& job, const fs::path& frames, const fs::path& film,
                  const std::vector<Shortfall>& shortfalls) {
    if (command.json) {
        nlohmann::ordered_json result{
            {"out", job.out.string()}, {"cache", (job.out / "cache").string()}, {"frames", frames.string()}};
        if (!film.empty()) result["film"] = film.string();
        result["shortfalls"] = shortfalls_json(shortfalls);
        print_json(result);
    } else if (!command.quiet) {
        fmt::print("{}\n", film.empty() ? frames.string() : film.string());
    }
}

}  // namespace

int run_verb(const Command& command) {
    const Job job = scene_job(command);
    const scene::Output output = scene::overlay_look(job.scene->look, command.look, command.set).output;
    const fs::path frames = frames_folder(job.out, command.look);
    const fs::path film = output.film ? film_file(job.out, job.scene->name, command.look) : fs::path();

    Stages stages{sim_args(command, job), render_args(command, job)};
    if (command.dry_run) return print_calls({sim_call(stages), render_call(stages, true)});
    if (!film.empty()) require_ffmpeg();

    if (const int code = conduct(stages, {.terminal = isatty(STDERR_FILENO) != 0, .quiet = command.quiet});
        code != kDone)
        return code;
    if (!film.empty()) update_film({frames, CacheReader(job.out).frames(), job.scene->frames.fps}, film);
    const std::vector<Shortfall> shortfalls = shortfalls_in(job.out);
    print_result(command, job, frames, film, shortfalls);
    const int short_of = tell_shortfalls(shortfalls, command);
    const int damaged = command.verify ? report_damages(job.out, verify_output(job.out), command) : int(kDone);
    return damaged != kDone ? damaged : short_of;
}

}  // namespace thixo
