#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/stage_args.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/film.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

/// Those of the cache's frames that the command asks for.
std::vector<int> frames_of(const Command& command, const CacheReader& cache) {
    if (command.frames.empty()) return cache.frames();
    std::vector<int> frames = parse_frame_range(command.frames);
    std::erase_if(frames, [&](int n) { return !cache.has_frame(n); });
    return frames;
}

/// What a command that changes the look leaves to do first: pictures of that look, mixed or rendered.
std::optional<RenderArgs> pictures_first(const Command& command, const Job& job) {
    if (command.set.empty()) return std::nullopt;
    RenderArgs args = render_args(command, job);
    args.relight = true;
    return args;
}

/// A film at another rate or of another codec does not take the place of the one that `run` makes.
std::string ending_of(const Command& command, Codec codec) {
    const std::string rate = command.fps > 0 ? fmt::format(".{:g}fps", command.fps) : "";
    return rate + (codec == Codec::h265 ? ".h265" : "") + film_ending(codec);
}

}  // namespace

int film_verb(const Command& command) {
    const Job job = render_job(command);
    const fs::path root = job.pictures.empty() ? job.out : job.pictures;
    const std::optional<RenderArgs> first = pictures_first(command, job);
    if (first && command.dry_run) return print_calls({stage_call("thixo-render", first->print())});
    if (command.dry_run) return kDone;
    require_ffmpeg();
    if (first)
        if (const int code = run_to_end(stage_call("thixo-render", first->print())); code != kDone) return code;

    const CacheReader cache(job.out);
    const scene::Scene scene = scene::parse_cached_scene(cache.scene_text(), "manifest.json");
    const Codec codec = parse_codec(command.codec);
    const bool relit = first && command.look.empty();
    const FilmPlan plan{relit ? root / kRelitFrames : frames_folder(root, command.look), frames_of(command, cache),
                        command.fps > 0 ? command.fps : scene.frames.fps, codec};
    const fs::path film = film_file(root, scene.name, relit ? "relit" : command.look, ending_of(command, codec));
    if (!film_is_current(plan, film)) {
        log_info("encoding {}", film.string());
        make_film(plan, film);
    }
    if (command.json) print_json(nlohmann::ordered_json{{"film", film.string()}});
    if (!command.json && !command.quiet) fmt::print("{}\n", film.string());
    return kDone;
}

}  // namespace thixo
