#include <cstdlib>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/ownership.h"
#include "pipeline/contract/stage_args.h"
#include "pipeline/geometry/mesh_io.h"
#include "render/preview/preview.h"

namespace thixo {

namespace {

using namespace preview;

struct Job {
    std::vector<int> frames, missing;
    int probe = 0;     // a frame with points, to decide on what and from where
    std::string what;  // particles or surfels
};

std::uint64_t points_in(const CacheReader& reader, int frame) {
    const ManifestFrame* f = reader.manifest().find(frame);
    return f->surfels > 0 ? f->surfels + (std::uint64_t(1) << 62) : f->particles;  // any surfels beat particles
}

Job plan(const CacheReader& reader, const RenderArgs& args) {
    Job job;
    for (const int number : args.frames.empty() ? reader.frames() : parse_frame_range(args.frames))
        (reader.has_frame(number) ? job.frames : job.missing).push_back(number);
    if (job.frames.empty())
        throw CacheError("{}: the cache holds none of the frames asked for; simulate them first", args.out);
    job.probe = job.frames.front();
    for (const int number : job.frames)
        if (points_in(reader, number) > points_in(reader, job.probe)) job.probe = number;
    return job;
}

Frame load(const CacheReader& reader, int number, const std::string& what) {
    Frame frame = reader.load_facts(number);
    (what == "surfels" ? frame.surfels : frame.particles) =
        what == "surfels" ? reader.load_surfels(number) : reader.load_particles(number);
    return frame;
}

void load_meshes(const CacheReader& reader, const Frame& frame, Meshes& meshes) {
    for (const FrameObstacle& o : frame.obstacles)
        if (!o.asset.empty() && !meshes.contains(o.asset))
            meshes[o.asset] = parse_ply(reader.load_asset(o.asset), "assets/" + o.asset + ".ply");
}

// The range of the attribute over all frames: a colour means the same value throughout a film.
std::optional<ValueRange> common_range(const CacheReader& reader, const Job& job, const std::string& attribute) {
    if (attribute.empty() || job.frames.size() < 2) return std::nullopt;
    ValueRange range;
    for (const int number : job.frames) {
        if (const int signal = interrupted()) throw InterruptedError(signal);
        const PointSet points = job.what == "surfels" ? reader.load_surfels(number) : reader.load_particles(number);
        if (points.count == 0) continue;
        const ValueRange own = attribute_range(points, attribute);
        range.add(own.lower);
        range.add(own.upper);
    }
    if (range.empty()) return std::nullopt;
    return range;
}

// The look's camera, which moves by itself; or one view for all frames where it sees nothing of the fullest of them.
std::optional<View> choose_view(const Frame& frame, const scene::Look& look, const Meshes& meshes) {
    if (!misses(look_view(look.camera, frame.time, look.output.width, look.output.height), frame)) return std::nullopt;
    log_info("preview: the look's camera sees no point of frame {}; drawing from a view that fits it", frame.number);
    return fitting_view(frame_bounds(frame, meshes), look.output.width, look.output.height);
}

}  // namespace

int run_preview(const RenderArgs& args, const scene::Look& look) {
    if (args.follow)
        throw InputError("preview: --follow does not apply to previews; draw again when more frames are cached");
    // llvmpipe reads its number of threads from the environment when the context is made; pictures do not depend on it.
    if (args.threads > 0) setenv("LP_NUM_THREADS", std::to_string(args.threads).c_str(), 1);
    const CacheReader reader(args.out);
    Job job = plan(reader, args);
    Meshes meshes;
    PreviewOptions options;
    options.attribute = args.attribute;
    {
        const Frame frame = reader.load_frame(job.probe);
        job.what = options.what = resolve_what(frame, args.what, args.attribute);
        load_meshes(reader, frame, meshes);
        options.view = choose_view(frame, look, meshes);
    }
    options.range = common_range(reader, job, args.attribute);

    const std::filesystem::path folder = make_subfolder(args.out, "preview");
    remove_stale_temporaries(folder);
    Previewer previewer;
    Progress progress("preview", static_cast<int>(job.frames.size()), args.machine_progress);
    Image8 picture;
    int done = 0;
    for (const int number : job.frames) {
        if (const int signal = interrupted()) throw InterruptedError(signal);
        const Frame frame = load(reader, number, job.what);
        load_meshes(reader, frame, meshes);
        previewer.draw(frame, look, meshes, options, picture);
        const std::string colours = args.attribute.empty() ? "material" : args.attribute;
        const std::filesystem::path file = folder / fmt::format("{}.{}.{:04d}.png", job.what, colours, number);
        require_own(file, is_own_png);
        write_png(file, picture);
        progress.update(++done, fmt::format("frame {}", number));
    }
    progress.finish();
    if (!job.missing.empty())
        throw CacheError(
            "{}: frame {} is not in the cache ({} of the frames asked for are missing); simulate them first", args.out,
            job.missing.front(), job.missing.size());
    return kDone;
}

}  // namespace thixo
