#include "sim/stage/run.h"

#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/interruption.h"
#include "pipeline/base/log.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "pipeline/contract/argument_words.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/folder_lock.h"
#include "pipeline/contract/look_images.h"
#include "pipeline/contract/machine_memory.h"
#include "pipeline/contract/scene_hash.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/shortfall_json.h"
#include "sim/loop/step.h"
#include "sim/stage/checkpoint.h"
#include "sim/stage/estimate.h"
#include "sim/stage/frame_output.h"
#include "sim/stage/probes.h"
#include "sim/stage/setup.h"
#include "sim/stage/stats.h"

namespace thixo {
namespace {

namespace fs = std::filesystem;

scene::Scene load(const SimArgs& args) {
    scene::Scene scene = scene::load_scene(args.scene, args.set, args.draft);
    if (args.seed) scene.solver.seed = *args.seed;
    return scene;
}

int last_frame(const scene::Scene& scene, const SimArgs& args) {
    if (args.initial) return scene.frames.first;
    if (args.frames.empty()) return scene.frames.last;
    const int last = parse_frame_range(args.frames).back();
    if (last < scene.frames.first || last > scene.frames.last)
        throw InputError("--frames {} ends outside the scene's frames {} to {}", args.frames, scene.frames.first,
                         scene.frames.last);
    return last;
}

void refuse_other_simulation(const Manifest& there, const scene::Scene& scene, const fs::path& out) {
    std::string keys;
    const scene::Scene old = scene::parse_cached_scene(there.scene_text, (out / "cache" / "manifest.json").string());
    for (const std::string& key : scene::differing_keys(old, scene)) keys += (keys.empty() ? "" : ", ") + key;
    throw InputError(
        "{}: holds another simulation, which differs in {}; give --out for another folder, or --restart to discard it",
        (out / "cache").string(), keys.empty() ? "what this program computes" : keys);
}

int estimate(const scene::Scene& scene, int last) {
    // On disk a particle takes about 50 bytes a frame, a surfel 64; a liquid has a surfel in five particles.
    constexpr double kDisk = 65, kSurfelDisk = 64;
    const Estimate expected = estimate_run(scene);
    const Size& size = expected.size;
    const double particles = size.particles, surfels = size.surfels + size.cut;
    const double frames = last - scene.frames.first + 1;
    const double disk_per_frame = kDisk * particles + kSurfelDisk * surfels;
    nlohmann::ordered_json answer = {{"particles", std::llround(particles)},
                                     {"memory", static_cast<std::int64_t>(memory_of(size))},
                                     {"disk", static_cast<std::int64_t>(disk_per_frame * frames)},
                                     {"disk_bytes_per_frame", static_cast<std::int64_t>(disk_per_frame)},
                                     {"shortfalls", shortfalls_json(expected.shortfalls)}};
    if (size.shattered > 0) {
        answer["crack_surfels"] = std::llround(size.cut);
        answer["crack_surfels_most"] = std::llround(size.shattered);
    }
    fmt::print("{}\n", answer.dump());
    return kDone;
}

std::string note(const Simulation& sim) {
    return fmt::format("{} particles, {} steps", sim.particles.size(), sim.stats.steps);
}

/// What frames show beside the state.
struct Drawn {
    std::vector<DrawnBoundary> boundaries;
    ColouredShapes coloured;
};

void write_frame(Simulation& sim, CacheWriter& cache, const Drawn& drawn, const fs::path& out, double started) {
    const Frame frame = make_frame(sim, drawn.boundaries, drawn.coloured);
    cache.write_frame(frame);
    append_probes(out, sim);
    append_stats(out, sim, frame.totals, wall_seconds() - started);
}

/// What changes the scene and names the folder, but nothing that leaves the bytes as they are.
std::string replay_words(SimArgs args) {
    args.frames.clear();
    args.threads = 0;
    args.quiet = args.machine_progress = args.restart = false;
    std::string line;
    for (const std::string& word : args.print()) line += (line.empty() ? "" : " ") + shell_word(word);
    return line;
}

/// The state of the last finished frame. An interruption writes it: between two steps, or from a thread of its own where
/// a step takes too long.
class LastState {
  public:
    explicit LastState(const fs::path& out) : out_(out) {}
    void set(int frame, std::string bytes) {
        const std::lock_guard lock(mutex_);
        frame_ = frame;
        bytes_ = std::move(bytes);
    }
    void write() {
        const std::lock_guard lock(mutex_);
        if (written_ != frame_) write_checkpoint(out_, frame_, bytes_);
        written_ = frame_;
    }

  private:
    fs::path out_;
    std::mutex mutex_;
    int frame_ = -1, written_ = -1;
    std::string bytes_;
};

/// A run's cache: new, discarded, or continued; and the simulation where it goes on.
struct Start {
    CacheWriter cache;
    Simulation simulation;
    bool from_checkpoint;
};
Start start(const scene::Scene& scene, const CacheIdentity& identity, const SimArgs& args) {
    const fs::path out = args.out;
    Simulation sim = make_simulation(scene);
    sim.problem.replay = replay_words(args);
    if (const double memory = memory_of(final_size(sim.problem.scene, sim)); memory > machine_memory())
        log_warning(
            "this simulation may need {} of memory at its last frame, and this machine has {}; raise "
            "solver.spacing, or let emitters stop earlier",
            bytes_text(memory), bytes_text(machine_memory()));
    if (!CacheReader::exists(out) || args.restart) {
        remove_checkpoints(out);
        CacheWriter cache = args.restart ? CacheWriter::restart(out, identity) : CacheWriter::create(out, identity);
        return {std::move(cache), std::move(sim), false};
    }
    const int kept = CacheReader(out).last_sound(scene.frames.first);
    const bool restored = restore_checkpoint(out, kept, identity.simulation_hash, sim);
    CacheWriter cache = CacheWriter::resume(out, identity, restored ? sim.clock.frame : scene.frames.first - 1);
    return {std::move(cache), std::move(sim), restored};
}

}  // namespace

int run_simulation(const SimArgs& args) {
    set_quiet(args.quiet);
    set_thread_count(args.threads);
    const scene::Scene scene = load(args);
    const int first = scene.frames.first, last = last_frame(scene, args);
    if (args.estimate) return estimate(scene, last);

    const fs::path out = args.out;
    const CacheIdentity identity{scene.name, scene::print_cached_scene(scene), scene::simulation_hash(scene)};
    Progress progress("sim", last - first + 1, args.machine_progress);
    if (CacheReader::exists(out) && !args.restart) {
        const CacheReader there(out);
        if (there.manifest().simulation_hash != identity.simulation_hash)
            refuse_other_simulation(there.manifest(), scene, out);
        if ((last < scene.frames.last || there.complete()) && there.is_whole(first, last)) {
            progress.update(last - first + 1, "already there");
            progress.finish();
            return kDone;
        }
    }
    for (const std::string& warning : scene::scene_warnings(scene)) log_warning("{}", warning);
    const FolderLock lock(out);
    double started = wall_seconds();
    Start begin = start(scene, identity, args);
    Simulation& sim = begin.simulation;
    CacheWriter& cache = begin.cache;
    const Drawn drawn{store_boundaries(sim.problem.scene, cache), coloured_shapes(sim.problem.scene)};
    scene::store_images(scene.look, cache);
    cache.require_assets();
    progress.update(begin.from_checkpoint ? sim.clock.frame - first + 1 : 0,
                    begin.from_checkpoint ? "continued" : "from the start");
    begin_probe_file(out, sim, begin.from_checkpoint ? sim.clock.frame : first - 1);
    begin_stats_file(out, begin.from_checkpoint ? sim.clock.frame : first - 1);
    if (!begin.from_checkpoint) {
        refresh_surface(sim);
        evaluate(sim);
        write_frame(sim, cache, drawn, out, started);
        progress.update(1, note(sim));
    }
    catch_interrupts();
    LastState state(out);
    if (!args.initial) state.set(sim.clock.frame, print_checkpoint(sim, identity.simulation_hash));
    const InterruptionWatch watch("thixo-sim", [&] { state.write(); });
    while (sim.clock.frame < last) {
        sim.stats = StepStats{};
        started = wall_seconds();
        if (!advance_frame(sim, [] { return interrupted() != 0; })) {
            state.write();
            progress.finish();
            throw InterruptedError(interrupted());
        }
        write_frame(sim, cache, drawn, out, started);
        state.set(sim.clock.frame, print_checkpoint(sim, identity.simulation_hash));
        if ((sim.clock.frame - first) % scene.solver.checkpoint_every == 0 || sim.clock.frame == last) state.write();
        progress.update(sim.clock.frame - first + 1, note(sim));
    }
    if (last == scene.frames.last) cache.finish();
    progress.finish();
    return kDone;
}

}  // namespace thixo
