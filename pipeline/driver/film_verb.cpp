#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/picture_files.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/stage_args.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/film.h"
#include "pipeline/driver/job.h"
#include "pipeline/driver/json_output.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

/// Those of the cache's frames that the command asks for. Tells how many of them have no picture.
std::vector<int> frames_of(const Command& command, const CacheReader& cache, const fs::path& pictures) {
    const std::vector<int> frames = command.frames.empty() ? cache.frames() : parse_frame_range(command.frames);
    for (const int n : frames)
        if (!cache.has_frame(n))
            throw CacheError("{}: frame {} is not in the cache; simulate it first", cache.folder().string(), n);
    const auto missing = std::ranges::count_if(frames, [&](int n) { return !fs::exists(png_path(pictures, n)); });
    if (missing > 0)
        log_warning("{} of {} frames have no picture in {}; the film holds the picture before in their place", missing,
                    frames.size(), pictures.string());
    return frames;
}

/// What a command that changes the look leaves to do first: pictures of that look, mixed or rendered.
std::optional<RenderArgs> pictures_first(const Command& command, const Job& job) {
    const bool draft = command.draft && !job.scene;  // of a scene it chooses the folder
    if (command.set.empty() && (command.restart || draft))
        throw InputError("film: --{} goes with --set; without it the frames are shown as they are",
                         command.restart ? "restart" : "draft");
    if (command.set.empty()) return std::nullopt;
    if (!command.look.empty())
        throw InputError("film: --look shows the frames of a look as they are; change the look file in place of --set");
    RenderArgs args = render_args(command, job);
    args.relight = true;
    return args;
}

/// A film of some frames, at another rate or of another codec does not take the place of the one that `run` makes.
std::string ending_of(const Command& command, Codec codec) {
    const std::string frames = command.frames.empty() ? "" : "." + command.frames;
    const std::string rate = command.fps > 0 ? fmt::format(".{:g}fps", command.fps) : "";
    return frames + rate + (codec == Codec::h265 ? ".h265" : "") + film_ending(codec);
}

}  // namespace

int film_verb(const Command& command) {
    const Job job = render_job(command);
    const fs::path root = job.pictures.empty() ? job.out : job.pictures;
    const std::optional<RenderArgs> first = pictures_first(command, job);
    require_ffmpeg();
    if (first)
        if (const int code = run_to_end(stage_call("thixo-render", first->print())); code != kDone) return code;

    const CacheReader cache(job.out);
    const scene::Scene scene = scene::parse_cached_scene(cache.scene_text(), "manifest.json");
    const Codec codec = parse_codec(command.codec);
    const fs::path pictures = first ? root / kRelitFrames : frames_folder(root, command.look);
    const FilmPlan plan{pictures, frames_of(command, cache, pictures), command.fps > 0 ? command.fps : scene.frames.fps,
                        codec};
    const fs::path film = film_file(root, scene.name, first ? "relit" : command.look, ending_of(command, codec));
    update_film(plan, film);
    if (command.json) print_json(nlohmann::ordered_json{{"film", film.string()}});
    if (!command.json && !command.quiet) fmt::print("{}\n", film.string());
    return kDone;
}

}  // namespace thixo
