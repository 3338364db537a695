#include "render/film.h"

#include <immintrin.h>

#include <array>
#include <atomic>
#include <csignal>
#include <optional>
#include <span>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "render/denoise/denoise.h"
#include "render/pixel_filter.h"
#include "render/warp.h"

namespace thixo::render {
namespace {

constexpr int kTileSide = 16;

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

/// A pixel, and what a denoiser is told of it.
struct Samples {
    Pixel pixel;
    GuidePixel guide;
    std::vector<Vec3d> groups;  // of lights: the sum of their radiance over the even samples, then over the odd ones

    explicit Samples(std::size_t count = 0) : groups(2 * count, Vec3d(0, 0, 0)) {}
    /// Of the half that the next sample belongs to.
    std::span<Vec3d> half() {
        const std::size_t count = groups.size() / 2;
        return std::span(groups).subspan(std::size_t(pixel.samples % 2) * count, count);
    }
    Vec3d group_mean(std::size_t k) const { return (groups[k] + groups[groups.size() / 2 + k]) / pixel.samples; }
};

void add_sample(Samples& samples, const World& world, const PixelFilter& filter, const FilmSettings& settings, int x,
                int y) {
    Pixel& pixel = samples.pixel;
    Sampler sampler(settings.seed, std::uint32_t(x), std::uint32_t(y), std::uint32_t(pixel.samples));
    const Vec2f offset = filter.offset(sampler.next2()), lens = sampler.next2();
    const float time = world.shutter.moves() ? sampler.next() : 0;
    const Ray ray = world.camera_ray(float(x) + 0.5f + offset.x(), float(y) + 0.5f + offset.y(), lens, time);
    FirstHit first;
    const Vec3f light = radiance(world, ray, sampler, first, settings.strategy, samples.half());
    pixel.add(light, first, world);
    if (settings.denoise) samples.guide.add(light, first, world.camera);
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
void sample_tile(std::span<Samples> pixels, const World& world, const PixelFilter& filter, const FilmSettings& settings,
                 int left, int top, int width) {
    const int all = settings.samples;
    for (int target = settings.noise > 0 ? std::min(kFirstSamples, all) : all;; target = std::min(2 * target, all)) {
        double noise = 0;
        for (std::size_t k = 0; k < pixels.size(); ++k) {
            while (pixels[k].pixel.samples < target)
                add_sample(pixels[k], world, filter, settings, left + int(k) % width, top + int(k) / width);
            noise += visible_noise(pixels[k].pixel) / double(pixels.size());
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

/// The channels of light groups, three each, by group.
using GroupChannels = std::vector<std::array<float*, 3>>;
constexpr std::array<const char*, 3> kColours{"R", "G", "B"};

std::string group_channel(const std::string& group, std::size_t colour) {
    return fmt::format("light_{}.{}", group, kColours[colour]);
}

std::string noisy_channel(std::size_t colour) { return fmt::format("noisy.{}", kColours[colour]); }

/// Found when all channels are there: adding moves them.
GroupChannels group_channels(Image& image, const LightGroups& groups) {
    GroupChannels channels(groups.names.size());
    for (std::size_t k = 0; k < channels.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c)
            channels[k][c] = image.find(group_channel(groups.names[k], c))->values.data();
    return channels;
}

void store(const Channels& channels, std::size_t i, const Pixel& pixel) {
    for (std::size_t p = 0; p < kPassCount; ++p) {
        if (!channels[p][0]) continue;
        const PassValue value = pixel.value(p);
        for (int k = 0; k < kPasses[p].channels(); ++k) channels[p][std::size_t(k)][i] = float(value[k]);
    }
}

/// The rectangle [x0, x1) x [y0, y1) of a picture.
struct Part {
    int x0, y0, x1, y1;
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    std::size_t pixels() const { return std::size_t(width()) * std::size_t(height()); }
};

/// Samples a part of the picture and calls store(x, y, samples) for its pixels, in parallel.
template <class Store>
void sample(const World& world, const FilmSettings& settings, const Part& part,
            const std::function<bool(int, int)>& progress, Store&& store) {
    const PixelFilter filter;
    // Tiles of the whole picture, whatever is cut out of it: a tile's pixels decide together how long to go on.
    const int first_column = part.x0 / kTileSide, first_row = part.y0 / kTileSide;
    const int columns = (part.x1 - 1) / kTileSide - first_column + 1, rows = (part.y1 - 1) / kTileSide - first_row + 1;
    std::atomic<int> done{0};
    std::atomic<bool> stopped{false};
    parallel_chunks(
        std::size_t(columns) * std::size_t(rows),
        [&](std::size_t tile, std::size_t, std::size_t) {
            if (stopped) return;
            const FlushDenormals flush;
            const int left = (first_column + int(tile) % columns) * kTileSide,
                      top = (first_row + int(tile) / columns) * kTileSide;
            const int right = std::min(left + kTileSide, world.camera.width),
                      bottom = std::min(top + kTileSide, world.camera.height);
            std::vector<Samples> pixels(std::size_t(right - left) * std::size_t(bottom - top),
                                        Samples(world.light_groups.names.size()));
            sample_tile(pixels, world, filter, settings, left, top, right - left);
            for (int y = std::max(top, part.y0); y < std::min(bottom, part.y1); ++y)
                for (int x = std::max(left, part.x0); x < std::min(right, part.x1); ++x, ++done)
                    store(x, y, pixels[std::size_t(y - top) * std::size_t(right - left) + std::size_t(x - left)]);
            if (interrupted() || (progress && !progress(done, int(part.pixels())))) stopped = true;
        },
        1);
    if (stopped) throw InterruptedError(interrupted() ? interrupted() : SIGTERM);
}

/// Planes of a picture that start at its pixel (x, y).
struct Placed {
    const Planes& planes;
    int x, y;
    /// The part of it, as a channel.
    void copy(int plane, const Part& part, float* channel) const {
        for (int row = 0; row < part.height(); ++row)
            std::copy_n(planes.at(plane, part.x0 - x, part.y0 - y + row), part.width(), channel + row * part.width());
    }
};

/// Puts what is denoised in its place, and keeps the noisy colours.
void put_denoised(const Denoised& clean, const Part& wide, const Part& part, const GroupChannels& groups,
                  Image& image) {
    for (std::size_t c = 0; c < 3; ++c) {
        ImageChannel& colour = *image.find(kColours[c]);
        image.find(noisy_channel(c))->values = colour.values;
        Placed{clean.light, wide.x0, wide.y0}.copy(int(c), part, colour.values.data());
        for (std::size_t k = 0; k < groups.size(); ++k)
            Placed{clean.groups[k], wide.x0, wide.y0}.copy(int(c), part, groups[k][c]);
    }
}

Part part_of(const FilmSettings& settings, const Camera& camera) {
    if (settings.x1 == 0) return {0, 0, camera.width, camera.height};
    return {settings.x0, settings.y0, settings.x1, settings.y1};
}

/// With a margin, as far as the picture has one.
Part widened(const Part& part, int margin, const Camera& camera) {
    return {std::max(0, part.x0 - margin), std::max(0, part.y0 - margin), std::min(camera.width, part.x1 + margin),
            std::min(camera.height, part.y1 + margin)};
}

}  // namespace

Image render(const World& world, const FilmSettings& settings, const std::function<bool(int, int)>& progress) {
    const Part part = part_of(settings, world.camera);
    THIXO_ASSERT(part.width() > 0 && part.height() > 0 && settings.samples > int(settings.denoise),
                 "{} x {} pixels, {} samples", part.width(), part.height(), settings.samples);
    Image image(part.width(), part.height());
    image.attributes = pass_attributes(world);
    const std::size_t count = world.light_groups.names.size();
    for (std::size_t c = 0; c < 3 && settings.denoise; ++c) image.add(noisy_channel(c));
    for (const std::string& name : world.light_groups.names)
        for (std::size_t c = 0; c < 3; ++c) image.add(group_channel(name, c));
    const Channels channels = add_channels(image, world.passes);
    const GroupChannels groups = group_channels(image, world.light_groups);
    const Part wide = widened(part, settings.denoise ? kDenoiseReach : 0, world.camera);
    std::optional<Guides> guides;
    if (settings.denoise) guides.emplace(wide.width(), wide.height(), count);
    sample(world, settings, wide, progress, [&](int x, int y, const Samples& samples) {
        if (guides) guides->store(x - wide.x0, y - wide.y0, samples.guide, samples.groups);
        if (x < part.x0 || x >= part.x1 || y < part.y0 || y >= part.y1) return;
        const std::size_t i = std::size_t(y - part.y0) * std::size_t(part.width()) + std::size_t(x - part.x0);
        store(channels, i, samples.pixel);
        for (std::size_t k = 0; k < count; ++k)
            for (std::size_t c = 0; c < 3; ++c) groups[k][c][i] = float(samples.group_mean(k)[Eigen::Index(c)]);
    });
    if (guides) put_denoised(denoise(*std::move(guides)), wide, part, groups, image);
    return image;
}

}  // namespace thixo::render
