#include "render/stage.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <filesystem>
#include <optional>
#include <set>
#include <thread>

#include "pipeline/base/error.h"
#include "pipeline/base/interruption.h"
#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/folder_lock.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/machine_memory.h"
#include "pipeline/contract/picture_cost.h"
#include "pipeline/contract/picture_files.h"
#include "pipeline/contract/scene_hash.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/vertex_normals.h"
#include "render/film.h"
#include "render/frame_world.h"
#include "render/preview/preview.h"
#include "render/relight.h"
#include "render/surfel_blocks.h"
#include "render/view_transform.h"

namespace thixo::render {
namespace {

namespace fs = std::filesystem;

void rest_or_stop() {
    if (const int signal = interrupted()) throw InterruptedError(signal);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (const int signal = interrupted()) throw InterruptedError(signal);
}

CacheReader open_cache(const RenderArgs& args) {
    // A follower may be started before the simulation has written anything.
    while (args.follow && !CacheReader::exists(args.out)) rest_or_stop();
    return CacheReader(args.out);
}

/// Everything but the cached frame that a picture's bytes depend on.
std::string look_identity(const scene::Scene& scene, std::uint64_t seed, const RenderArgs& args) {
    std::string text = scene::look_hash(scene.look) + fmt::format(" {}", seed);
    for (const scene::Material& m : scene.materials) text += fmt::format(" {}={}", m.name, m.look);
    for (const scene::Body& b : scene.bodies)
        if (!b.look.empty()) text += fmt::format(" {}={}", b.name, b.look);
    for (const scene::Boundary& b : scene.world.boundaries) text += fmt::format(" {}={}", b.name, b.look);
    if (!args.crop.empty()) text += " crop " + args.crop;
    if (args.relight) text += " relit";  // within half rounding of a rendered one, not equal to it
    return hash_hex(text);
}

/// The part asked for, or all of the picture. Throws InputError where it reaches beyond the picture.
Crop crop_of(const RenderArgs& args, const scene::Output& output) {
    if (args.crop.empty()) return {0, 0, output.width, output.height};
    const Crop crop = parse_crop(args.crop);
    if (crop.width > output.width - crop.x || crop.height > output.height - crop.y)
        throw InputError("--crop {} reaches beyond the picture of {} x {} pixels", args.crop, output.width,
                         output.height);
    return crop;
}

std::string frames_name(const RenderArgs& args) {
    if (!args.look.empty()) return "frames." + fs::path(args.look).stem().string();
    return args.relight ? "frames.relit" : "frames";
}

/// Whether the look itself asks for light groups, apart from those that relighting adds to what it renders.
bool asks_for_groups(RenderArgs args, const std::string& cache_scene_text) {
    args.relight = false;
    return resolve_scene(args, cache_scene_text).look.output.passes.lights;
}

class Stage {
  public:
    explicit Stage(const RenderArgs& args)
        : args_(args),
          reader_(open_cache(args)),
          scene_(resolve_scene(args, reader_.scene_text())),
          wants_groups_(args.relight && asks_for_groups(args, reader_.scene_text())),
          seed_(args.seed.value_or(scene_.solver.seed)),
          crop_(crop_of(args, scene_.look.output)),
          look_(look_identity(scene_, seed_, args)),
          root_(args.pictures.empty() ? args.out : args.pictures),
          folder_(root_ / frames_name(args)),
          locks_(folder_) {}

    int run() {
        const std::vector<int> frames = frames_asked();
        make_subfolder(root_, folder_.filename());
        for (const int number : frames) require_own_picture(folder_, number);
        if (!args_.restart) refuse_other_looks(frames);
        remove_stale_temporaries(folder_);
        Progress progress("render", int(frames.size()), args_.machine_progress);
        std::vector<int> missing;
        std::deque<int> waiting(frames.begin(), frames.end());
        std::size_t held = 0;  // of those at the end of `waiting`: by other processes
        int done = 0;
        progress.update(0, "");
        while (!waiting.empty()) {
            const int number = waiting.front();
            waiting.pop_front();
            held = std::min(held, waiting.size());
            if (!wait_for(number)) {
                missing.push_back(number);
            } else if (const std::optional<std::string> note = make_picture(number)) {
                progress.update(++done, *note);
            } else {  // another renderer is at it, and may be killed: come back
                waiting.push_back(number);
                if (++held == waiting.size()) rest_or_stop();
            }
        }
        progress.finish();
        if (!missing.empty())
            throw CacheError("{}: frame {}{} is not in the cache; simulate it first", reader_.folder().string(),
                             missing.front(),
                             missing.size() > 1 ? fmt::format(" (and {} more)", missing.size() - 1) : "");
        return kDone;
    }

  private:
    std::vector<int> frames_asked() const {
        if (!args_.frames.empty()) return parse_frame_range(args_.frames);
        if (!args_.follow) {
            if (reader_.frames().empty())
                throw CacheError("{}: the cache holds no frame yet; simulate first", reader_.folder().string());
            return reader_.frames();
        }
        const scene::Scene cached = scene::parse_cached_scene(reader_.scene_text(), "manifest.json");
        std::vector<int> frames;
        for (int n = cached.frames.first; n <= cached.frames.last; ++n) frames.push_back(n);
        return frames;
    }

    PictureIdentity identity(int number) const {
        const ManifestFrame* f = reader_.manifest().find(number);
        return {reader_.manifest().scene,  look_, f ? f->hash() : "", number, f ? f->time : 0,
                scene_.look.output.samples};
    }

    void refuse_other_looks(const std::vector<int>& frames) const {
        for (const int number : frames)
            if (picture_state(folder_, identity(number)) == PictureState::other_look)
                throw InputError(
                    "{} was made with another look; --restart replaces it, a look of its own (--look FILE) or --out "
                    "DIR keeps it",
                    exr_path(folder_, number).string());
    }

    /// True where the frame is cached; with --follow, once it is. False: it will not come.
    bool wait_for(int number) {
        while (!reader_.has_frame(number)) {
            if (!args_.follow || (reader_.complete() && !reader_.refresh())) return false;
            if (reader_.refresh()) continue;
            rest_or_stop();
        }
        if (const int signal = interrupted()) throw InterruptedError(signal);
        return true;
    }

    void load_meshes(const Frame& frame) {
        for (const FrameObstacle& o : frame.obstacles) {
            if (o.asset.empty() || meshes_.contains(o.asset)) continue;
            meshes_[o.asset] = parse_ply(reader_.load_asset(o.asset), "assets/" + o.asset + ".ply");
        }
    }

    void warn(const std::vector<std::string>& missing, const World& world, const Frame& frame) {
        for (const std::string& name : missing)
            if (warned_.insert(name).second)
                log_warning("look.appearances has no '{}'; it is drawn in matt grey", name);
        if (world.rays->dropped_surfels() > 0)
            log_warning("frame {}: {} surfels have no area or are not finite; they are left out", frame.number,
                        world.rays->dropped_surfels());
        if (world.rays->whirling_surfels() > 0 && warned_.insert("\n\n").second)
            log_warning(
                "frame {}: {} surfels turn by more than {} radians while the shutter is open, and their surface gapes; "
                "open it for a shorter time, or simulate at a higher frames.fps",
                frame.number, world.rays->whirling_surfels(), kMostTurn);
        if (frame.surfels.count == 0 && frame.particles.count > 0 && warned_.insert("\n").second)
            log_warning(
                "frame {} has particles but no surfels (surface.enabled is off): the matter is not drawn; see preview",
                frame.number);
    }

    /// Renders and writes the picture unless it is there; returns what happened, for the progress line. Nothing where
    /// another process is rendering it.
    std::optional<std::string> make_picture(int number) {
        const PictureIdentity id = identity(number);
        const auto there = [&] { return picture_state(folder_, id) == PictureState::done; };
        if (there()) return fmt::format("frame {} was there", number);
        if (!locks_.take(number)) return std::nullopt;
        const bool made_meanwhile = there();
        if (!made_meanwhile && !relight(id)) render_picture(id);
        locks_.release(number);
        return fmt::format("frame {}{}", number, made_meanwhile ? " was there" : "");
    }

    /// Makes the picture of that in frames/ by mixing its light groups, where that is asked for and enough. Says why
    /// where it is not.
    bool relight(const PictureIdentity& id) {
        if (!args_.relight) return false;
        const fs::path beside = root_ / "frames", source = fs::exists(beside) ? beside : fs::path(args_.out) / "frames";
        const StoredPicture stored = read_picture(source, id.frame);
        Relighting mix;
        if (!stored.problem.empty())
            mix.reason = stored.problem;
        else if (stored.cache != id.cache)
            mix.reason = "its picture is of another cache";
        else if (stored.lights.empty())
            mix.reason = "its picture does not say what lights it";
        else
            mix = relighting(stored.lights, light_record(scene_, seed_));
        std::optional<Image> image;
        if (mix.reason.empty()) {
            image = read_exr(exr_path(source, id.frame), Checksum::required);
            if ((!mix.is_same() || wants_groups_) && !has_light_groups(*image))
                mix.reason = "its picture has no light groups (look.output.passes.lights)";
        }
        if (!mix.reason.empty()) {
            if (warned_.insert(mix.reason).second) log_info("frame {} is rendered: {}", id.frame, mix.reason);
            return false;
        }
        if (!mix.is_same()) image = relit(std::move(*image), mix);
        image->attributes[kLightsKey] = light_record(scene_, seed_);
        finish_picture(id, std::move(*image));
        return true;
    }

    void render_picture(const PictureIdentity& id) {
        const int number = id.frame;
        const Frame frame = reader_.load_frame(number);
        load_meshes(frame);
        std::vector<std::string> missing;
        if (!pictures_) {  // not before: the cache may just have begun
            require_memory(scene::picture_cost(scene_.look, &reader_).memory, "a picture of this look with its images",
                           "choose a smaller look.output or smaller images");
            pictures_ = load_pictures(scene_.look, &reader_);
        }
        const World world = make_world(frame, meshes_, *pictures_, scene_, scene_.look, missing);
        warn(missing, world, frame);
        FilmSettings film;
        film.samples = scene_.look.output.samples;
        film.noise = float(scene_.look.output.noise);
        film.seed =
            random_bits(seed_, std::uint64_t(number), 0, 0x66696c6dull);  // another pattern of noise in every frame
        film.denoise = scene_.look.output.denoise;
        film.x0 = crop_.x;
        film.y0 = crop_.y;
        film.x1 = crop_.x + crop_.width;
        film.y1 = crop_.y + crop_.height;
        Image image = render(world, film, [](int, int) { return interrupted() == 0; });
        if (!args_.crop.empty())
            image.attributes["thixo.crop"] =
                fmt::format("{} of {} x {}", args_.crop, scene_.look.output.width, scene_.look.output.height);
        image.attributes[kLightsKey] = light_record(scene_, seed_);
        finish_picture(id, std::move(image));
    }

    void finish_picture(const PictureIdentity& id, Image image) {
        const Image8 display = to_display(image, scene_.look.output.view, scene_.look.output.exposure);
        write_picture(folder_, id, std::move(image), display);
    }

    RenderArgs args_;
    CacheReader reader_;
    scene::Scene scene_;
    bool wants_groups_;  // the look asks for light groups: a picture without them would not be of that look
    std::uint64_t seed_;
    Crop crop_;
    std::string look_;
    fs::path root_, folder_;
    NumberLocks locks_;  // of frames
    AssetMeshes meshes_;
    std::optional<Pictures> pictures_;
    std::set<std::string> warned_;
};

}  // namespace

scene::Scene resolve_scene(const RenderArgs& args, const std::string& cache_scene_text) {
    scene::Scene scene = args.scene.empty() ? scene::parse_cached_scene(cache_scene_text, "manifest.json", args.set)
                                            : scene::load_scene(args.scene, args.set);
    if (!args.look.empty()) scene.look = scene::overlay_look(scene.look, args.look, args.set);
    if (args.draft) scene::apply_draft(scene.look);
    scene.look.output.passes.lights |= args.relight;  // what is rendered can be mixed the next time
    return scene;
}

int run_stage(const RenderArgs& args) {
    set_quiet(args.quiet);
    set_thread_count(args.threads);
    catch_interrupts();
    const InterruptionWatch watch("thixo-render", [] {});  // pictures are written whole: nothing else is to be kept
    if (args.preview) return run_preview(args, resolve_scene(args, open_cache(args).scene_text()));
    return Stage(args).run();
}

}  // namespace thixo::render
