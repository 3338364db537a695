#include <cstdlib>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/frame_looks.h"
#include "pipeline/contract/ownership.h"
#include "pipeline/contract/scene_origin.h"
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

/// A frame as it is drawn. Obstacles and fronts are relative to the origin of the points, as these are. Bodies and obstacles name
/// the looks that they wear.
Frame dressed(Frame frame, const scene::Scene& scene, const Vec3d& origin) {
    for (FrameObstacle& o : frame.obstacles) {
        o.look = look_of_obstacle(scene, o);
        for (const int k : {0, 1, 2}) o.transform[static_cast<std::size_t>(4 * k + 3)] -= origin[k];
    }
    for (FrameFront& f : frame.fronts)
        for (auto& node : f.nodes)
            for (const int k : {0, 1, 2}) node[static_cast<std::size_t>(k)] -= origin[k];
    for (FrameBody& b : frame.bodies) b.material = look_of_body(scene, b);
    return frame;
}

Frame load(const CacheReader& reader, int number, const scene::Scene& scene, const std::string& what) {
    Frame frame = reader.load_facts(number);
    PointSet& points = what == "surfels" ? frame.surfels : frame.particles;
    points = what == "surfels" ? reader.load_surfels(number) : reader.load_particles(number);
    return dressed(std::move(frame), scene, points.origin);
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

int run_preview(const RenderArgs& args, const scene::Scene& scene) {
    if (args.follow)
        throw InputError("preview: --follow does not apply to previews; draw again when more frames are cached");
    // llvmpipe reads its number of threads from the environment when the context is made; pictures do not depend on it.
    if (args.threads > 0) setenv("LP_NUM_THREADS", std::to_string(args.threads).c_str(), 1);
    const CacheReader reader(args.out);
    Job job = plan(reader, args);
    Meshes meshes;
    PreviewOptions options;
    options.attribute = args.attribute;
    scene::Look look = scene.look;
    {
        const Frame in_world = reader.load_frame(job.probe);
        const Vec3d origin = in_world.particles.origin;  // of all frames: it follows from the scene
        const Frame frame = dressed(in_world, scene, origin);
        look = scene::relative_to(std::move(look), origin);
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
        const Frame frame = load(reader, number, scene, job.what);
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
