// How soon a picture of a cached frame is clean. For a few numbers of samples it prints processor seconds and relMSE,
// before and after the denoiser. The reference has many samples.
//
//   clean_bench CACHE FRAME REFERENCE.exr REFERENCE_SAMPLES SAMPLES [PICTURES]
//
// Pictures are 240 pixels wide. The reference is read where it is there, and otherwise made and stored. SAMPLES is a list
// such as 6,24. PICTURES is the beginning of the names under which every picture is written as PNG too.
//
//   relMSE = mean of (c - r)^2 / (r^2 + 0.01) over pixels and colours
#include <fmt/core.h>
#include <sys/resource.h>

#include <filesystem>

#include "pipeline/base/error.h"
#include "pipeline/base/timer.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/stage_args.h"
#include "pipeline/geometry/mesh_io.h"
#include "render/film.h"
#include "render/frame_world.h"
#include "render/view_transform.h"

namespace {

using namespace thixo;
using namespace thixo::render;

constexpr std::array<const char*, 3> kColours{"R", "G", "B"};

double processor_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct CachedFrame {
    scene::Scene scene;
    World world;
};

CachedFrame load(const std::string& path, int number) {
    const CacheReader reader(path);
    CachedFrame cached;
    cached.scene = scene::parse_cached_scene(reader.scene_text(), "manifest.json");
    scene::Output& output = cached.scene.look.output;
    output.height = 240 * output.height / output.width;
    output.width = 240;
    const Frame frame = reader.load_frame(number);
    AssetMeshes meshes;
    for (const FrameObstacle& o : frame.obstacles)
        if (!o.asset.empty()) meshes[o.asset] = parse_ply(reader.load_asset(o.asset), o.asset);
    std::vector<std::string> missing;
    cached.world =
        make_world(frame, meshes, load_pictures(cached.scene.look, &reader), cached.scene, cached.scene.look, missing);
    return cached;
}

Image picture(const World& world, int samples, bool denoise, std::uint64_t seed) {
    FilmSettings film;
    film.samples = samples;
    film.denoise = denoise;
    film.seed = seed;
    return render::render(world, film);
}

double rel_mse(const Image& image, const std::string& layer, const Image& reference) {
    double sum = 0;
    for (const char* colour : kColours) {
        const std::vector<float>&a = image.get(layer + colour), &b = reference.get(colour);
        for (std::size_t i = 0; i < a.size(); ++i)
            sum += square(double(a[i]) - double(b[i])) / (square(double(b[i])) + 0.01);
    }
    return sum / (3 * double(image.pixels()));
}

int body(int argc, char** argv) {
    if (argc < 6) throw InputError("usage: clean_bench CACHE FRAME REFERENCE.exr REFERENCE_SAMPLES SAMPLES [PICTURES]");
    const CachedFrame cached = load(argv[1], std::stoi(argv[2]));
    const scene::Output& output = cached.scene.look.output;
    const auto show = [&](const Image& image, const std::string& name) {
        if (argc > 6) write_png(argv[6] + name + ".png", to_display(image, output.view, output.exposure));
    };
    if (!std::filesystem::exists(argv[3])) write_exr(argv[3], picture(cached.world, std::stoi(argv[4]), false, 1));
    const Image reference = read_exr(argv[3]);
    show(reference, "reference");
    for (const int samples : parse_frame_range(argv[5])) {
        const double begin = processor_seconds();
        const Image noisy = picture(cached.world, samples, false, 2);
        const double between = processor_seconds();
        const Image clean = picture(cached.world, samples, true, 2);
        const double end = processor_seconds();
        const double a = rel_mse(noisy, "", reference), b = rel_mse(clean, "", reference);
        fmt::print(
            "{:3} samples: CPU {:7.2f} s, relMSE {:.3e}, CPU x relMSE {:.3e}; denoised {:7.2f} s, {:.3e}, {:.3e}\n",
            samples, between - begin, a, (between - begin) * a, end - between, b, (end - between) * b);
        show(noisy, fmt::format("{}.noisy", samples));
        show(clean, fmt::format("{}.clean", samples));
    }
    return kDone;
}

}  // namespace

int main(int argc, char** argv) { return thixo::run_guarded("clean_bench", body, argc, argv); }
