// Light groups add up to the picture, and are what light it anew.
#include "render/relight.h"

#include <gtest/gtest.h>

#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

using namespace worlds;

constexpr int kWidth = 64, kHeight = 48;

/// A sky, a lamp, and a sun that shares the lamp's group.
std::vector<scene::Light> lights() {
    scene::Light sky, lamp, sun;
    sky.name = "sky";
    lamp.name = "lamp";
    lamp.type = scene::LightType::area;
    lamp.position = {-1, -0.5, 1.5};
    lamp.direction = {1, 0.5, -1.5};
    lamp.strength = 5;
    lamp.group = "warm";
    sun.name = "sun";
    sun.type = scene::LightType::sun;
    sun.direction = {0.3, 0.2, -1};
    sun.group = "warm";
    return {sky, lamp, sun};
}

/// A glass ball on a checked ground.
World world_under(const std::vector<scene::Light>& lights) {
    World world;
    scene::Appearance glass, matt;
    glass.type = scene::AppearanceType::dielectric;
    matt.checker = 0.2;
    const Index ball = add_object(world, glass), floor = add_object(world, matt);
    SurfelSet set = shapes::one_object(shapes::sphere(2000, 0.3f, {0, 0, 0.3f}, 0.2f));
    set.object = {ball};
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(floor));
    world.rays = std::make_unique<RayScene>(std::move(set), std::move(meshes));
    for (const scene::Light& l : lights) world.lights.push_back(make_light(l));
    world.light_groups = light_groups(lights);
    look(world, {0, -1.5, 0.8}, {0, 0, 0.25}, 40, kWidth, kHeight);
    return world;
}

Image picture(const World& world, bool denoise = false, int samples = 8) {
    FilmSettings film;
    film.samples = samples;
    film.denoise = denoise;
    return render(world, film);
}

/// The largest distance of a channel from the sum of its light groups. It is in parts of the half rounding that storing
/// all of them brings, 2^-11 of each.
double misfit(const Image& image, const std::string& colour) {
    double most = 0;
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        double sum = 0, rounding = 0;
        for (const ImageChannel& c : image.channels)
            if (c.name.starts_with("light_") && c.name.ends_with("." + colour)) {
                sum += double(c.values[i]);
                rounding += std::abs(double(c.values[i])) * 0x1p-11;
            }
        most = std::max(most, std::abs(sum - double(image.get(colour)[i])) / std::max(rounding, 1e-9));
    }
    return most;
}

scene::Scene scene_of(const std::vector<scene::Light>& lights) {
    scene::Scene scene;
    scene.look.lights = lights;
    return scene;
}

TEST(LightGroups, AddUpToThePicture) {
    const Image image = picture(world_under(lights()));
    for (const char* colour : {"R", "G", "B"}) EXPECT_LT(misfit(image, colour), 1) << colour;
    for (const char* group : {"background", "sky", "warm"})
        EXPECT_NE(image.find(fmt::format("light_{}.R", group)), nullptr);
    EXPECT_EQ(image.find("light_lamp.R"), nullptr);
}

TEST(LightGroups, AddUpToTheDenoisedPicture) {
    const Image image = picture(world_under(lights()), true);
    for (const char* colour : {"R", "G", "B"}) EXPECT_LT(misfit(image, colour), 1) << colour;
}

TEST(LightGroups, LeaveThePictureAsItIs) {
    World world = world_under(lights());
    for (const bool denoise : {false, true}) {
        const Image with = picture(world, denoise);
        World plain = world_under(lights());
        plain.light_groups = {};
        const Image without = picture(plain, denoise);
        for (const ImageChannel& c : without.channels) EXPECT_TRUE(with.get(c.name) == c.values) << c.name;
    }
}

TEST(LightGroups, AreWhatTheirLightsGiveAlone) {
    // The others are dark then, but stand in the way as before.
    std::vector<scene::Light> dark = lights();
    dark[1].strength = dark[2].strength = 0;
    const Image image = picture(world_under(lights()), false, 64), alone = picture(world_under(dark), false, 64);
    double mean = 0, other = 0;
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        mean += double(image.get("light_sky.G")[i]) / double(image.pixels());
        other += double(alone.get("G")[i]) / double(image.pixels());
    }
    // The picture's own error bounds that of a part of it.
    EXPECT_NEAR(mean, other, 5 * std::hypot(standard_error(image), standard_error(alone)));
}

TEST(Relight, EqualsWhatIsRenderedWithinNoise) {
    // The lamp and the sun at twice the strength and without blue, the sky at half of its own.
    std::vector<scene::Light> now = lights();
    now[0].strength *= 0.5;
    for (const std::size_t k : {1u, 2u}) {
        now[k].strength *= 2;
        now[k].colour = {1, 1, 0};
    }
    const Relighting mix = relighting(light_record(scene_of(lights()), 1), light_record(scene_of(now), 1));
    ASSERT_EQ(mix.reason, "");
    const Image before = picture(world_under(lights()), false, 64), rendered = picture(world_under(now), false, 64);
    const Image image = relit(before, mix.factor);
    const Vec3d a = mean_colour(image), b = mean_colour(rendered);
    // Light that doubles doubles the error of its part at most.
    const double error = std::hypot(2 * standard_error(before), standard_error(rendered));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 5 * error) << c;
    EXPECT_EQ(image.find("variance.G"), nullptr);
    EXPECT_LT(misfit(image, "B"), 1);
}

TEST(Relight, UnchangedLightsGiveTheSamePicture) {
    const Image image = picture(world_under(lights()));
    const std::string record = light_record(scene_of(lights()), 1);
    const Image same = relit(image, relighting(record, record).factor);
    for (std::size_t i = 0; i < image.pixels(); ++i) ASSERT_NEAR(same.get("G")[i], image.get("G")[i], 1e-5);
}

std::string reason(const scene::Scene& now) {
    return relighting(light_record(scene_of(lights()), 1), light_record(now, 1)).reason;
}

TEST(Relight, SaysWhyAPictureHasToBeRendered) {
    scene::Scene now = scene_of(lights());
    now.look.camera.fov = 41;
    EXPECT_EQ(reason(now), "look.camera.fov differs");
    now = scene_of(lights());
    now.look.lights[1].strength = 7;
    EXPECT_EQ(reason(now), "the lights of the group 'warm' change by different factors");
    now = scene_of(lights());
    now.look.lights.pop_back();
    EXPECT_NE(reason(now), "");
    scene::Scene dark = scene_of(lights());
    dark.look.lights[0].strength = 0;
    EXPECT_EQ(relighting(light_record(dark, 1), light_record(scene_of(lights()), 1)).reason,
              "look.lights.sky gave no light before");
    now = scene_of(lights());
    now.look.output.exposure = 2;
    now.look.background = {0, 0, 0};
    EXPECT_EQ(reason(now), "");
}

}  // namespace
}  // namespace thixo::render
