#include "pipeline/driver/repair.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/picture_files.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/driver/film.h"
#include "pipeline/driver/scratch_folder.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

using Part = Damage::Part;

bool any(const VerifyReport& report, Part part) {
    return std::any_of(report.damages.begin(), report.damages.end(), [&](const Damage& d) { return d.part == part; });
}

/// The cache's own scene as a file, with its images beside it under the names by which it calls them.
fs::path write_cached_scene(const CacheReader& reader, const ScratchFolder& scratch) {
    for (const CacheFile& asset : reader.manifest().assets)
        if (!asset.name.ends_with(kAssetExtensions[0]) && is_sound(reader.folder(), asset))
            write_whole(scratch.path() / asset.hash, reader.load_asset(asset.hash));
    const fs::path file = scratch.path() / (reader.manifest().scene + ".yaml");
    write_whole(file, reader.scene_text());
    return file;
}

int simulate(const Command& command, const Job& job, const fs::path& scene, bool restart) {
    SimArgs args = sim_args(command, job);
    args.scene = scene.string();
    args.restart = restart;
    return run_to_end(stage_call("thixo-sim", args.print()));
}

void repair_cache(const Command& command, const Job& job, const VerifyReport& report) {
    const bool manifest = any(report, Part::manifest);
    if (!manifest && !any(report, Part::cache)) return;
    if (job.scene) {
        simulate(command, job, command.path, manifest);
        return;
    }
    if (manifest) {
        log_warning("without its manifest a cache is made again from the scene alone; give the scene with --out");
        return;
    }
    const CacheReader reader(job.out / "cache");
    const ScratchFolder scratch(job.out, "verify");
    if (simulate(command, job, write_cached_scene(reader, scratch), false) != kDone)
        log_warning("the cache cannot be made again from the scene that it carries; give the scene with --out");
}

/// Frames to render, with one that is whole: the renderer refuses where that has another look than the cache's.
std::string frames_of(const std::vector<int>& damaged, const CacheReader& reader, const fs::path& folder) {
    std::string frames;
    for (const int n : damaged) frames += fmt::format("{}{}", frames.empty() ? "" : ",", n);
    for (const int n : reader.frames())
        if (!std::binary_search(damaged.begin(), damaged.end(), n) && read_picture(folder, n).problem.empty())
            return fmt::format("{},{}", frames, n);
    return frames;
}

void repair_pictures(const Command& command, const Job& job, const VerifyReport& report) {
    const fs::path folder = job.out / "frames";
    std::vector<int> damaged;
    for (const Damage& d : report.damages)
        if (d.part == Part::pictures && d.file.parent_path() == folder) damaged.push_back(d.frame);
    if (damaged.empty()) return;
    const CacheReader reader(job.out / "cache");
    std::sort(damaged.begin(), damaged.end());
    RenderArgs args = render_args(command, job);
    args.frames = frames_of(damaged, reader, folder);
    run_to_end(stage_call("thixo-render", args.print()));
}

/// The film of frames/; where a picture has changed it is not current either.
void repair_film(const Job& job) {
    const CacheReader reader(job.out / "cache");
    const fs::path film = film_file(job.out, reader.manifest().scene, "");
    const double fps = scene::parse_cached_scene(reader.scene_text(), kManifestName).frames.fps;
    const FilmPlan plan{job.out / "frames", reader.frames(), fps};
    if (fs::exists(film)) update_film(plan, film);
}

/// The checkpoints that are damaged serve no run; the simulation sets them aside by itself where it comes upon them.
void remove_checkpoints(const VerifyReport& report) {
    for (const Damage& d : report.damages)
        if (d.part == Part::checkpoint && starts_with(d.file, "THIXOCKP")) fs::remove(d.file);
}

}  // namespace

void repair_output(const Command& command, const Job& job, const VerifyReport& report) {
    remove_checkpoints(report);
    repair_cache(command, job, report);
    if (!CacheReader::exists(job.out / "cache")) return;
    repair_pictures(command, job, report);
    repair_film(job);
}

}  // namespace thixo
