#include "pipeline/driver/job.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "pipeline/base/error.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/scene_io.h"

namespace thixo {
namespace fs = std::filesystem;
namespace {

std::string stem(const std::string& file) { return fs::path(file).stem().string(); }

void fill_common(const Command& command, const Job& job, CommonArgs& args) {
    args.out = job.out.string();
    args.frames = command.frames;
    args.set = command.set;
    args.threads = command.threads;
    args.seed = command.seed;
    args.draft = command.draft;
    args.quiet = command.quiet;
}

}  // namespace

fs::path default_out(const std::string& scene_name, bool draft) {
    return fs::path("out") / (scene_name + (draft ? ".draft" : ""));
}

fs::path frames_folder(const fs::path& out, const std::string& look_file) {
    return out / (look_file.empty() ? "frames" : "frames." + stem(look_file));
}

fs::path film_file(const fs::path& out, const std::string& scene_name, const std::string& look_file,
                   const std::string& ending) {
    return out / (scene_name + (look_file.empty() ? "" : "." + stem(look_file)) + ending);
}

Job scene_job(const Command& command) {
    Job job;
    job.scene = scene::load_scene(command.path, command.set, command.draft);
    job.out = command.out.empty() ? default_out(job.scene->name, command.draft) : fs::path(command.out);
    return job;
}

Job cache_job(const Command& command) {
    const fs::path path = fs::absolute(command.path).lexically_normal();
    if (!fs::exists(path)) throw InputError("{}: there is no such file or folder", command.path);
    if (!CacheReader::exists(path)) throw CacheError("{}: holds no cache; ./thixo sim SCENE makes one", command.path);
    const CacheReader reader(path);
    Job job;
    const fs::path folder = fs::absolute(reader.folder()).lexically_normal();
    const fs::path cache = folder.has_filename() ? folder : folder.parent_path();
    if (cache.filename() != "cache")
        throw InputError("{}: a cache folder must be called 'cache'; rename it", command.path);
    job.out = cache.parent_path();
    return job;
}

namespace {

bool names_scene(const Command& command) {
    return fs::is_regular_file(command.path) && fs::path(command.path).filename() != "manifest.json";
}

}  // namespace

Job render_job(const Command& command) {
    if (names_scene(command)) return scene_job(command);
    Job job = cache_job(command);
    if (!command.out.empty()) job.pictures = fs::absolute(command.out).lexically_normal();
    return job;
}

Job scene_or_cache_job(const Command& command) {
    if (names_scene(command)) return scene_job(command);
    if (!command.out.empty())
        throw InputError(
            "--out goes with a scene; what belongs to the cache {} is written beside it: copy it to have it elsewhere",
            command.path);
    return cache_job(command);
}

Job output_job(const Command& command) {
    fs::path path = fs::absolute(command.path).lexically_normal();
    if (fs::is_regular_file(path) && path.filename() != kManifestName) {
        Job job = scene_job(command);
        if (!fs::is_directory(job.out)) throw InputError("{}: there is no such folder", job.out.string());
        return job;
    }
    if (!fs::exists(path)) throw InputError("{}: there is no such file or folder", command.path);
    if (path.filename() == kManifestName) path = path.parent_path();
    if (!path.has_filename()) path = path.parent_path();
    Job job;
    job.out = path.filename() == "cache" ? path.parent_path() : path;
    if (!fs::exists(fs::symlink_status(job.out / "cache")))
        throw CacheError("{}: holds no cache; ./thixo sim SCENE makes one", command.path);
    return job;
}

SimArgs sim_args(const Command& command, const Job& job) {
    SimArgs args;
    fill_common(command, job, args);
    args.scene = command.path;
    args.restart = command.restart;
    return args;
}

RenderArgs render_args(const Command& command, const Job& job) {
    RenderArgs args;
    fill_common(command, job, args);
    if (job.scene) args.scene = command.path;
    args.look = command.look;
    args.pictures = job.pictures.string();
    args.crop = command.crop;
    args.restart = command.restart;
    return args;
}

ProgramCall stage_call(const std::string& name, std::vector<std::string> args) {
    const char* const set = std::getenv("THIXO_BIN");
    const fs::path folder = set && *set ? fs::path(set) : fs::read_symlink("/proc/self/exe").parent_path();
    return {name, folder / name, std::move(args)};
}

int print_calls(const std::vector<ProgramCall>& calls) {
    for (const ProgramCall& call : calls) fmt::print("{}\n", shell_line(call));
    return kDone;
}

}  // namespace thixo
