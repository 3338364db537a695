#include "render/film.h"

#include <immintrin.h>

#include <atomic>
#include <csignal>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "render/pixel_filter.h"

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

struct Pixel {
    Vec3f colour, variance, normal, albedo;
    float alpha, depth;
};

Pixel render_pixel(const World& world, const PixelFilter& filter, const FilmSettings& settings, int x, int y) {
    Vec3d sum = Vec3d::Zero(), squares = Vec3d::Zero(), normal = Vec3d::Zero(), albedo = Vec3d::Zero();
    int covered = 0;
    float depth = kFar;
    for (int i = 0; i < settings.samples; ++i) {
        Sampler sampler(settings.seed, std::uint32_t(x), std::uint32_t(y), std::uint32_t(i));
        const Vec2f offset = filter.offset(sampler.next2()), lens = sampler.next2();
        const Ray ray = world.camera.ray(float(x) + 0.5f + offset.x(), float(y) + 0.5f + offset.y(), lens);
        FirstHit first;
        const Vec3d c = radiance(world, ray, sampler, first, settings.strategy).cast<double>();
        sum += c;
        squares += c.cwiseProduct(c);
        if (!first.found) continue;
        ++covered;
        normal += first.normal.cast<double>();
        albedo += first.albedo.cast<double>();
        if (first.depth > 0) depth = std::min(depth, first.depth);
    }
    const double n = settings.samples;
    Pixel pixel;
    const Vec3d mean = sum / n;
    pixel.colour = mean.cast<float>();
    pixel.variance = Vec3f::Zero();
    if (settings.samples > 1)
        pixel.variance = ((squares / n - mean.cwiseProduct(mean)).cwiseMax(0.0) / (n - 1)).cast<float>();
    pixel.normal = (normal / n).cast<float>();
    pixel.albedo = (albedo / n).cast<float>();
    pixel.alpha = world.settings.transparent_background ? float(covered / n) : 1.0f;
    pixel.depth = depth;
    return pixel;
}

struct Channels {  // pointers into the image, fixed once all channels exist
    float *rgb[3], *alpha, *depth, *normal[3], *albedo[3], *variance[3];
};

Channels add_channels(Image& image) {
    const char* const rgb[] = {"R", "G", "B"};
    const char* const xyz[] = {"X", "Y", "Z"};
    for (const char* c : rgb) image.add(c, true);
    image.add("A", true);
    image.add("Z", false);
    for (const char* c : xyz) image.add(std::string("N.") + c, true);
    for (const char* c : rgb) image.add(std::string("albedo.") + c, true);
    for (const char* c : rgb) image.add(std::string("variance.") + c, false);
    Channels channels;
    const auto find = [&](const std::string& name) { return image.find(name)->values.data(); };
    for (int k = 0; k < 3; ++k) {
        channels.rgb[k] = find(rgb[k]);
        channels.normal[k] = find(std::string("N.") + xyz[k]);
        channels.albedo[k] = find(std::string("albedo.") + rgb[k]);
        channels.variance[k] = find(std::string("variance.") + rgb[k]);
    }
    channels.alpha = find("A");
    channels.depth = find("Z");
    return channels;
}

void store(const Channels& channels, std::size_t i, const Pixel& pixel) {
    for (int k = 0; k < 3; ++k) {
        channels.rgb[k][i] = pixel.colour[k];
        channels.normal[k][i] = pixel.normal[k];
        channels.albedo[k][i] = pixel.albedo[k];
        channels.variance[k][i] = pixel.variance[k];
    }
    channels.alpha[i] = pixel.alpha;
    channels.depth[i] = pixel.depth;
}

}  // namespace

Image render(const World& world, const FilmSettings& settings, const std::function<bool(int, int)>& progress) {
    FilmSettings s = settings;
    if (s.x1 == 0) {
        s.x1 = world.camera.width;
        s.y1 = world.camera.height;
    }
    const int width = s.x1 - s.x0, height = s.y1 - s.y0;
    THIXO_ASSERT(width > 0 && height > 0 && s.samples > 0, "{} x {} pixels, {} samples", width, height, s.samples);
    Image image(width, height);
    const Channels channels = add_channels(image);
    const PixelFilter filter;
    const int columns = (width + kTile - 1) / kTile, rows = (height + kTile - 1) / kTile;
    std::atomic<int> done{0};
    std::atomic<bool> stopped{false};
    parallel_chunks(
        std::size_t(columns) * std::size_t(rows),
        [&](std::size_t tile, std::size_t, std::size_t) {
            if (stopped) return;
            const FlushDenormals flush;
            const int left = int(tile) % columns * kTile, top = int(tile) / columns * kTile;
            const int right = std::min(left + kTile, width), bottom = std::min(top + kTile, height);
            for (int y = top; y < bottom; ++y)
                for (int x = left; x < right; ++x)
                    store(channels, std::size_t(y) * std::size_t(width) + std::size_t(x),
                          render_pixel(world, filter, s, s.x0 + x, s.y0 + y));
            done += (right - left) * (bottom - top);
            if (interrupted() || (progress && !progress(done, width * height))) stopped = true;
        },
        1);
    if (stopped) throw InterruptedError(interrupted() ? interrupted() : SIGTERM);
    return image;
}

}  // namespace thixo::render
