// Environments: the density is one, what is sampled is what is evaluated, every strategy gives the same light.
#include "render/environment.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

float uniform(std::uint64_t i, std::uint64_t use) { return float(random_unit(23, i, use, 0)); }

Vec3f even_direction(std::uint64_t i) { return sample_cone({uniform(i, 7), uniform(i, 8)}, 2); }

Vec3f towards(double longitude, double latitude) {  // degrees
    const double a = longitude * kPi / 180, b = latitude * kPi / 180;
    return Vec3d(std::cos(b) * std::cos(a), std::cos(b) * std::sin(a), std::sin(b)).cast<float>();
}

/// A dim sky over a dark ground, and a sun of a few texels that is 2000 times as bright. It stands 40 degrees high
/// towards -y and gives half of the light on level ground.
constexpr int kWidth = 128, kHeight = 64;
std::shared_ptr<const Environment> sunny() {
    std::vector<Vec3f> radiance;
    for (int row = 0; row < kHeight; ++row)
        for (int column = 0; column < kWidth; ++column) {
            const bool sun = std::abs(column - 96) < 2 && std::abs(row - 18) < 2;
            const Vec3f sky = row < kHeight / 2 ? Vec3f(0.3f, 0.4f, 0.6f) : Vec3f(0.05f, 0.05f, 0.04f);
            radiance.push_back(sun ? Vec3f(600, 550, 500) : sky);
        }
    return std::make_shared<const Environment>(kWidth, kHeight, std::move(radiance));
}

std::shared_ptr<const Environment> constant(float value, int height = 8) {
    return std::make_shared<const Environment>(
        2 * height, height, std::vector<Vec3f>(std::size_t(2 * height * height), Vec3f::Constant(value)));
}

Light light_of(std::shared_ptr<const Environment> environment, double rotation = 0, double strength = 1) {
    scene::Light light;
    light.type = scene::LightType::environment;
    light.rotation = rotation;
    light.strength = strength;
    return make_light(light, std::move(environment));
}

TEST(Environment, ItsDensityIsOneOverTheSphere) {
    // By cells: the density is constant in each, so a sum over cell centres times solid angles is the integral exactly,
    // to float.
    const auto map = sunny();
    double sum = 0;
    for (int row = 0; row < kHeight; ++row)
        for (int column = 0; column < kWidth; ++column) {
            const double top = kPi * row / kHeight, bottom = kPi * (row + 1) / kHeight;
            const double z = (std::cos(top) + std::cos(bottom)) / 2, phi = 2 * kPi * (0.5 - (column + 0.5) / kWidth);
            const double r = std::sqrt(1 - z * z);
            sum += double(map->pdf(Vec3d(r * std::cos(phi), r * std::sin(phi), z).cast<float>())) * 2 * kPi / kWidth *
                   (std::cos(top) - std::cos(bottom));
        }
    EXPECT_NEAR(sum, 1, 1e-4);
}

TEST(Environment, IsSampledAsItsDensitySays) {
    const auto map = sunny();
    int in_sun = 0;
    constexpr int n = 20000;
    for (std::uint64_t i = 0; i < n; ++i) {
        const Environment::Sample s = map->sample({uniform(i, 0), uniform(i, 1)});
        EXPECT_NEAR(s.direction.norm(), 1, 1e-5f);
        // At a cell's edge rounding may find the neighbour's density: seen in 1 of 10 000.
        if (uniform(i, 0) > 0.001f) in_sun += map->radiance(s.direction).x() > 5;
        if (std::abs(map->pdf(s.direction) - s.pdf) > 1e-3f * s.pdf)
            ADD_FAILURE() << i << " " << s.direction.transpose();
        if (::testing::Test::HasFailure()) break;
    }
    // The integral of the density over the directions that show the sun, by even directions in a cone about it.
    double share = 0;
    constexpr int m = 100000;
    const float height = 1 - std::cos(0.3f);
    const Vec3f sun = towards(-90, 39.4);
    for (std::uint64_t i = 0; i < m; ++i) {
        const Vec3f d = to_world(sample_cone({uniform(i, 2), uniform(i, 3)}, height), sun);
        if (map->radiance(d).x() > 5) share += double(map->pdf(d) * height) * 2 * kPi / m;
    }
    EXPECT_NEAR(double(in_sun) / n, share, 0.02);  // 4 standard errors of both
    EXPECT_GT(share, 0.3);
}

TEST(Environment, LightIsNeverWithoutAChance) {
    // One texel alone shines; the bilinear light reaches into its neighbours.
    std::vector<Vec3f> radiance(16 * 8, Vec3f::Zero());
    radiance[3 * 16 + 15] = {1, 1, 1};  // at the seam
    const Environment map(16, 8, std::move(radiance));
    int lit = 0;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const Vec3f d = even_direction(i);
        if (map.radiance(d).maxCoeff() <= 0) continue;
        ++lit;
        EXPECT_GT(map.pdf(d), 0);
    }
    EXPECT_GT(lit, 200);
}

TEST(Environment, PlacesItsPicture) {
    // Rows of the picture: top, middle; columns: -x, +y, +x, -y from the left edge on.
    std::vector<Vec3f> radiance;
    for (int row = 0; row < 32; ++row)
        for (int column = 0; column < 64; ++column) radiance.push_back({float(row), float(column), 0});
    const Environment map(64, 32, std::move(radiance));
    EXPECT_NEAR(map.radiance({0, 0, 1}).x(), 0, 1e-3);
    EXPECT_NEAR(map.radiance({0, 0, -1}).x(), 31, 1e-3);
    EXPECT_NEAR(map.radiance(towards(0, 0)).y(), 31.5f, 1e-3);    // +x in the middle
    EXPECT_NEAR(map.radiance(towards(90, 0)).y(), 15.5f, 1e-3);   // +y a quarter to the left
    EXPECT_NEAR(map.radiance(towards(-90, 0)).y(), 47.5f, 1e-3);  // -y to the right
    EXPECT_NEAR(map.radiance(towards(0, 45)).x(), 7.5f, 1e-3);
}

TEST(Environment, ARotationTurnsItAboutTheVertical) {
    const Light still = light_of(sunny()), turned = light_of(sunny(), 50);
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3f d = even_direction(i);
        const float c = std::cos(50 * kPif / 180), s = std::sin(50 * kPif / 180);
        const Vec3f there(c * d.x() - s * d.y(), s * d.x() + c * d.y(), d.z());
        const Vec3f a = infinite_radiance(still, d), b = infinite_radiance(turned, there);
        EXPECT_LT((a - b).norm(), 2e-3f * (1 + a.norm()));
        const LightSample sample = sample_light(turned, {0, 0, 0}, {0, 0, 1}, {uniform(i, 0), uniform(i, 1)});
        EXPECT_LT((infinite_radiance(turned, sample.direction) - sample.radiance).norm(),
                  2e-3f * (1 + sample.radiance.norm()));
        EXPECT_NEAR(light_pdf(turned, {0, 0, 1}, sample.direction, 1), sample.pdf, 2e-3f * sample.pdf);
    }
}

TEST(Environment, OneThatIsBlackShinesNowhere) {
    const Light dark = light_of(constant(0));
    EXPECT_EQ(sample_light(dark, {0, 0, 0}, {0, 0, 1}, {0.3f, 0.6f}).pdf, 0);
    EXPECT_EQ(light_pdf(dark, {0, 0, 1}, {0, 0, 1}, 1), 0);
    EXPECT_EQ(light_strength(dark, {0, 0, 0}), 0);
}

Image picture(const Light& light, scene::AppearanceType type, double roughness, Strategy strategy, std::uint64_t seed) {
    scene::Appearance a;
    a.type = type;
    a.roughness = roughness;
    World world;
    world.lights = {light};
    world.settings.clamp = 0;
    const Index object = worlds::add_object(world, a);
    SurfelSet ball = shapes::one_object(shapes::sphere(800, 0.5f, {0, 0, 0.5f}));
    ball.object = {object};
    world.rays = std::make_unique<RayScene>(std::move(ball), std::vector<MeshObject>{worlds::ground(object)});
    worlds::look(world, {0, -3, 1.2}, {0, 0, 0.4}, 40, 24, 16);
    FilmSettings film;
    film.samples = 256;
    film.seed = seed;
    film.strategy = strategy;
    return render(world, film);
}

TEST(Environment, AConstantOneIsASky) {
    scene::Light sky;
    sky.strength = 0.7;
    sky.ground = {1, 1, 1};
    for (const auto type : {scene::AppearanceType::diffuse, scene::AppearanceType::plastic}) {
        const Image a = picture(make_light(sky), type, 0.2, Strategy::both, 1),
                    b = picture(light_of(constant(0.7f)), type, 0.2, Strategy::both, 2);
        const double noise = std::hypot(worlds::standard_error(a), worlds::standard_error(b));
        EXPECT_NEAR(worlds::mean_colour(a).y(), worlds::mean_colour(b).y(), 4 * noise);
        EXPECT_LT(noise, 0.01);
    }
}

TEST(Environment, WaysToSampleABrightSunInItAgree) {
    const Light light = light_of(sunny());
    for (const auto& [type, roughness] :
         {std::pair(scene::AppearanceType::diffuse, 0.0), {scene::AppearanceType::conductor, 0.4}}) {
        const Image both = picture(light, type, roughness, Strategy::both, 1),
                    lights = picture(light, type, roughness, Strategy::lights, 2),
                    surfaces = picture(light, type, roughness, Strategy::surfaces, 3);
        const double mean = worlds::mean_colour(both).y();
        for (const Image* other : {&lights, &surfaces}) {
            const double noise = std::hypot(worlds::standard_error(both), worlds::standard_error(*other));
            EXPECT_NEAR(worlds::mean_colour(*other).y(), mean, 4 * noise);
        }
        // Both together are no noisier than the better of the two, to the cost of choosing.
        EXPECT_LT(worlds::standard_error(both),
                  1.3 * std::min(worlds::standard_error(lights), worlds::standard_error(surfaces)));
        EXPECT_LT(worlds::standard_error(both), 0.02 * mean);
    }
}

TEST(Environment, LightsLevelGroundByItsIrradiance) {
    // int L cos over the upper half, by even directions.
    const auto map = sunny();
    double irradiance = 0;
    constexpr int n = 2000000;
    for (std::uint64_t i = 0; i < n; ++i) {
        const Vec3f d = even_direction(i);
        if (d.z() > 0) irradiance += double(map->radiance(d).y() * d.z()) * 4 * kPi / n;
    }
    const Light light = light_of(map, 77, 3);
    double sum = 0;
    constexpr int m = 20000;
    for (std::uint64_t i = 0; i < m; ++i) {
        const LightSample s = sample_light(light, {0, 0, 0}, {0, 0, 1}, {uniform(i, 0), uniform(i, 1)});
        sum += double(s.radiance.y() * std::max(0.0f, s.direction.z()) / s.pdf) / m;
    }
    EXPECT_NEAR(sum / (3 * irradiance), 1, 0.02);  // 3 standard errors: the sun takes a thousandth of the sphere
}

}  // namespace
}  // namespace thixo::render
