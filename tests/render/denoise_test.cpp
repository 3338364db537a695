// The denoiser takes noise away and nothing else.
#include "render/denoise/denoise.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

using namespace worlds;

constexpr int kWidth = 96, kHeight = 64, kSamples = 8;

/// A matt surface. The light of a sample is `mean` times an exponential random number. Its standard deviation is its
/// mean, as that of light from a few directions. `colour(x, y)` is what features say of it.
template <class Colour>
Guides noisy_surface(double mean, Colour&& colour) {
    const Camera camera;
    Guides guides(kWidth, kHeight);
    std::mt19937_64 random(5);
    std::exponential_distribution<double> light(1);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            GuidePixel pixel;
            FirstHit first;
            first.found = true;
            first.depth = 2;
            first.way = {0, 1, 0};
            first.normal = {0, -1, 0};
            first.seen = colour(x, y);
            for (int k = 0; k < kSamples; ++k) pixel.add(float(mean * light(random)) * first.seen, first, camera);
            guides.store(x, y, pixel);
        }
    return guides;
}

Vec3f white(int, int) { return {1, 1, 1}; }
Vec3f checker(int x, int y) { return (x / 8 + y / 8) % 2 ? Vec3f(0.9f, 0.5f, 0.2f) : Vec3f(0.1f, 0.2f, 0.3f); }

/// Squared error in parts of the squared true value, of the mean of both halves before denoising, and of a result.
template <class Colour>
std::pair<double, double> errors(double mean, Colour&& colour) {
    const Guides guides = noisy_surface(mean, colour);
    const Planes clean = denoise(guides).light;
    double before = 0, after = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 3; ++c) {
                const double truth = mean * double(colour(x, y)[c]);
                const double noisy = 0.5 * double(*guides.light[0].at(c, x, y) + *guides.light[1].at(c, x, y));
                before += square(noisy / truth - 1);
                after += square(double(*clean.at(c, x, y)) / truth - 1);
            }
    return {before, after};
}

TEST(Denoise, WhatHasNoNoiseStaysAsItIs) {
    // Ramps and edges that no feature shows. The variance is that of the samples, zero: nothing may be averaged.
    Guides guides(kWidth, kHeight);
    const auto truth = [](int x, int y) { return x < 40 ? 0.01 * x : 2 + 0.02 * y; };
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            GuidePixel pixel;
            for (int k = 0; k < kSamples; ++k) pixel.add(Vec3f::Constant(float(truth(x, y))), {}, Camera());
            guides.store(x, y, pixel);
        }
    const Planes clean = denoise(std::move(guides)).light;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) ASSERT_NEAR(*clean.at(0, x, y), truth(x, y), 1e-5);
}

TEST(Denoise, KeepsTheEnergyOfAnEvenSurface) {
    // The weights come from the other half, hence they know nothing of the noise that they average. So the mean is that
    // of the samples, within 5 standard errors of it.
    const Planes clean = denoise(noisy_surface(3, white)).light;
    double sum = 0;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) sum += double(*clean.at(1, x, y)) / (kWidth * kHeight);
    EXPECT_NEAR(sum, 3, 5 * 3 / std::sqrt(double(kWidth * kHeight * kSamples)));
}

TEST(Denoise, AnEvenSurfaceGetsTheMeanOfItsWindow) {
    // A window has 289 pixels. Half of them, and no more than that lost to weights, leave 1/144 of the squared error.
    const auto [before, after] = errors(3, white);
    EXPECT_LT(after, before / 144);
}

TEST(Denoise, EdgesThatFeaturesShowStaySharp) {
    // Every pixel is within four of an edge over which the colour changes ninefold. Errors are relative to the true
    // value, so that light which bleeds over an edge counts most.
    const auto [before, after] = errors(1, checker);
    EXPECT_LT(after, before / 20);
}

/// A ball on the ground under a sky and a lamp.
World ball_and_ground(const scene::Appearance& of_ball, const scene::Appearance& of_ground) {
    World world;
    const Index ball = add_object(world, of_ball), floor = add_object(world, of_ground);
    SurfelSet set = shapes::one_object(shapes::sphere(2000, 0.3f, {0, 0, 0.3f}, 0.2f));
    set.object = {ball};
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(floor));
    world.rays = std::make_unique<RayScene>(std::move(set), std::move(meshes));
    add_sky(world, 0.5);
    scene::Light lamp;
    lamp.type = scene::LightType::area;
    lamp.position = {-1, -0.5, 1.5};
    lamp.direction = {1, 0.5, -1.5};
    lamp.strength = 5;
    world.lights.push_back(make_light(lamp));
    look(world, {0, -1.5, 0.8}, {0, 0, 0.25}, 40, kWidth, kHeight);
    return world;
}

World glass_and_ground() {
    scene::Appearance glass, checked;
    glass.type = scene::AppearanceType::dielectric;
    checked.checker = 0.2;
    return ball_and_ground(glass, checked);
}

Image picture(const World& world, int samples, bool denoised) {
    FilmSettings film;
    film.samples = samples;
    film.denoise = denoised;
    film.seed = std::uint64_t(samples);
    return render(world, film);
}

/// Mean squared error of G, each in parts of the squared reference and 0.01 (W/(m^2 sr))^2.
double rel_mse(const std::vector<float>& image, const std::vector<float>& reference) {
    double sum = 0;
    for (std::size_t i = 0; i < image.size(); ++i)
        sum += square(double(image[i]) - double(reference[i])) / (square(double(reference[i])) + 0.01);
    return sum / double(image.size());
}

TEST(Denoise, NoiseOfLightFallsToAQuarter) {
    // Of a matt ball on matt ground. Where edges fill the picture the gain is less: no neighbour knows how much of a pixel
    // each side of an edge has.
    const World world = ball_and_ground({}, {});
    const Image reference = picture(world, 1024, false), image = picture(world, 8, true);
    EXPECT_LT(rel_mse(image.get("G"), reference.get("G")), rel_mse(image.get("noisy.G"), reference.get("G")) / 4);
}

TEST(Denoise, TheNoisyPictureAndAllOtherPassesStay) {
    const World world = glass_and_ground();
    const Image plain = picture(world, 4, false), denoised = picture(world, 4, true);
    for (const ImageChannel& c : plain.channels) {
        const bool colour = c.name == "R" || c.name == "G" || c.name == "B";
        EXPECT_TRUE(denoised.get(colour ? "noisy." + c.name : c.name) == c.values) << c.name;
    }
    EXPECT_FALSE(denoised.get("G") == plain.get("G"));
}

TEST(Denoise, IsTheSameAtAnyNumberOfThreads) {
    const Guides guides = noisy_surface(1, checker);
    std::vector<Planes> results;
    for (const int threads : {1, 2, 3}) {
        set_thread_count(threads);
        results.push_back(denoise(guides).light);
    }
    set_thread_count(0);
    for (int c = 0; c < 3; ++c)
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                ASSERT_EQ(*results[0].at(c, x, y), *results[1].at(c, x, y));
                ASSERT_EQ(*results[0].at(c, x, y), *results[2].at(c, x, y));
            }
}

TEST(Denoise, ACropHasTheBitsOfTheWhole) {
    World world = glass_and_ground();
    look(world, {0, -1.5, 0.8}, {0, 0, 0.25}, 40, 3 * kWidth, 2 * kHeight);
    FilmSettings film;
    film.samples = 2;
    film.denoise = true;
    const Image whole = render(world, film);
    film.x0 = 131;  // more than the reach from all but the upper edge
    film.y0 = 11;
    film.x1 = 158;
    film.y1 = 30;
    const Image crop = render(world, film);
    ASSERT_EQ(crop.channels.size(), whole.channels.size());
    for (std::size_t c = 0; c < crop.channels.size(); ++c)
        for (int y = 0; y < crop.height; ++y)
            for (int x = 0; x < crop.width; ++x)
                ASSERT_EQ(crop.channels[c].values[std::size_t(y * crop.width + x)],
                          whole.channels[c].values[std::size_t((y + film.y0) * whole.width + x + film.x0)])
                    << crop.channels[c].name;
}

}  // namespace
}  // namespace thixo::render
