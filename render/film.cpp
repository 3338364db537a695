#include "render/film.h"

#include <immintrin.h>

#include <array>
#include <atomic>
#include <csignal>
#include <span>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "render/pixel_filter.h"
#include "render/warp.h"

namespace thixo::render {
namespace {

constexpr int kTile = 16;

/// Denormals count as zero while this lives: on every thread that traces, or results and speed would depend on who
/// traces what.
class FlushDenormals {
  public:
    FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | _MM_FLUSH_ZERO_ON | kDenormalsAreZero); }
    ~FlushDenormals() { _mm_setcsr(before_); }
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

  private:
    static constexpr unsigned kDenormalsAreZero = 0x0040;
    unsigned before_;
};

void add_sample(Pixel& pixel, const World& world, const PixelFilter& filter, const FilmSettings& settings, int x,
                int y) {
    Sampler sampler(settings.seed, std::uint32_t(x), std::uint32_t(y), std::uint32_t(pixel.samples));
    const Vec2f offset = filter.offset(sampler.next2()), lens = sampler.next2();
    const Ray ray = world.camera.ray(float(x) + 0.5f + offset.x(), float(y) + 0.5f + offset.y(), lens);
    FirstHit first;
    const Vec3f light = radiance(world, ray, sampler, first, settings.strategy);
    pixel.add(light, first, world);
}

/// Noise of a pixel as the eye has it: the standard error of its mean over what a display makes of it,
///   error / (2 sqrt(max(mean, kDark)))   [1].
/// Below kDark the eye sees no relative noise.
double visible_noise(const Pixel& pixel) {
    constexpr double kDark = 0.02;
    const double mean = luminance(pixel.mean().cast<float>().eval());
    const double error = std::sqrt(luminance(pixel.variance().cast<float>().eval()));
    return error / (2 * std::sqrt(std::max(mean, kDark)));
}

constexpr int kFirstSamples = 8;

/// The pixels of a tile, sampled together: twice as often each time until their mean noise is under the target. One
/// pixel may have missed what its neighbours found.
void sample_tile(std::span<Pixel> pixels, const World& world, const PixelFilter& filter, const FilmSettings& settings,
                 int left, int top, int width) {
    const int all = settings.samples;
    for (int target = settings.noise > 0 ? std::min(kFirstSamples, all) : all;; target = std::min(2 * target, all)) {
        double noise = 0;
        for (std::size_t k = 0; k < pixels.size(); ++k) {
            while (pixels[k].samples < target)
                add_sample(pixels[k], world, filter, settings, left + int(k) % width, top + int(k) / width);
            noise += visible_noise(pixels[k]) / double(pixels.size());
        }
        if (target == all || noise <= double(settings.noise)) return;
    }
}

/// The values of a pass, a pointer for each of its channels; null where the pass is off.
using Channels = std::array<std::array<float*, 4>, kPassCount>;

Channels add_channels(Image& image, const scene::Passes& passes) {
    for (const Pass& pass : kPasses)
        for (int k = 0; pass.on(passes) && k < pass.channels(); ++k) image.add(pass.channel(k), pass.half);
    Channels channels{};  // found when all are there: adding moves them
    for (std::size_t p = 0; p < kPassCount; ++p)
        for (int k = 0; kPasses[p].on(passes) && k < kPasses[p].channels(); ++k)
            channels[p][std::size_t(k)] = image.find(kPasses[p].channel(k))->values.data();
    return channels;
}

void store(const Channels& channels, std::size_t i, const Pixel& pixel) {
    for (std::size_t p = 0; p < kPassCount; ++p) {
        if (!channels[p][0]) continue;
        const PassValue value = pixel.value(p);
        for (int k = 0; k < kPasses[p].channels(); ++k) channels[p][std::size_t(k)][i] = float(value[k]);
    }
}

}  // namespace

Image render(const World& world, const FilmSettings& settings, const std::function<bool(int, int)>& progress) {
    FilmSettings film = settings;
    if (film.x1 == 0) {
        film.x1 = world.camera.width;
        film.y1 = world.camera.height;
    }
    const int width = film.x1 - film.x0, height = film.y1 - film.y0;
    THIXO_ASSERT(width > 0 && height > 0 && film.samples > 0, "{} x {} pixels, {} samples", width, height,
                 film.samples);
    Image image(width, height);
    image.attributes = pass_attributes(world);
    const Channels channels = add_channels(image, world.passes);
    const PixelFilter filter;
    // Tiles of the whole picture, whatever is cut out of it: a tile's pixels decide together how long to go on.
    const int first_column = film.x0 / kTile, first_row = film.y0 / kTile;
    const int columns = (film.x1 - 1) / kTile - first_column + 1, rows = (film.y1 - 1) / kTile - first_row + 1;
    std::atomic<int> done{0};
    std::atomic<bool> stopped{false};
    parallel_chunks(
        std::size_t(columns) * std::size_t(rows),
        [&](std::size_t tile, std::size_t, std::size_t) {
            if (stopped) return;
            const FlushDenormals flush;
            const int left = (first_column + int(tile) % columns) * kTile,
                      top = (first_row + int(tile) / columns) * kTile;
            const int right = std::min(left + kTile, world.camera.width),
                      bottom = std::min(top + kTile, world.camera.height);
            std::array<Pixel, kTile * kTile> store_room;
            const std::span<Pixel> pixels(store_room.data(), std::size_t(right - left) * std::size_t(bottom - top));
            sample_tile(pixels, world, filter, film, left, top, right - left);
            for (int y = std::max(top, film.y0); y < std::min(bottom, film.y1); ++y)
                for (int x = std::max(left, film.x0); x < std::min(right, film.x1); ++x, ++done)
                    store(channels, std::size_t(y - film.y0) * std::size_t(width) + std::size_t(x - film.x0),
                          pixels[std::size_t(y - top) * std::size_t(right - left) + std::size_t(x - left)]);
            if (interrupted() || (progress && !progress(done, width * height))) stopped = true;
        },
        1);
    if (stopped) throw InterruptedError(interrupted() ? interrupted() : SIGTERM);
    return image;
}

}  // namespace thixo::render
