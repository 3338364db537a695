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

/// The appearances of a ball and of the checked ground that it is on: glass, or matter that glows.
std::vector<scene::Appearance> appearances(const Vec3d& glow) {
    scene::Appearance ball, matt;
    ball.name = "ball";
    matt.name = "matt";
    matt.checker = 0.2;
    ball.glow.strength = glow.maxCoeff();
    if (ball.glow.strength > 0)
        ball.glow.colour = glow / ball.glow.strength;
    else
        ball.type = scene::AppearanceType::dielectric;
    return {ball, matt};
}

World world_under(const std::vector<scene::Light>& lights, const Vec3d& glow = {0, 0, 0}) {
    World world;
    const std::vector<scene::Appearance> looks = appearances(glow);
    const Index ball = add_object(world, looks[0]), floor = add_object(world, looks[1]);
    SurfelSet set = shapes::one_object(shapes::sphere(2000, 0.3f, {0, 0, 0.3f}, 0.2f));
    set.object = {ball};
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(floor));
    world.rays = std::make_unique<RayScene>(std::move(set), std::move(meshes));
    for (const scene::Light& l : lights) world.lights.push_back(make_light(l));
    world.light_groups = light_groups(lights, glow.maxCoeff() > 0);
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

scene::Scene scene_of(const std::vector<scene::Light>& lights, const Vec3d& glow = {0, 0, 0}) {
    scene::Scene scene;
    scene.look.lights = lights;
    scene.look.appearances = appearances(glow);
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
    const Image image = relit(before, mix);
    const Vec3d a = mean_colour(image), b = mean_colour(rendered);
    // Light that doubles doubles the error of its part at most.
    const double error = std::hypot(2 * standard_error(before), standard_error(rendered));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 5 * error) << c;
    EXPECT_EQ(image.find("variance.G"), nullptr);
    EXPECT_LT(misfit(image, "B"), 1);
}

TEST(LightGroups, OfWhatGlowsAddUpToThePictureWithTheOthers) {
    const Image image = picture(world_under(lights(), {2, 1, 0.2}));
    for (const char* colour : {"R", "G", "B"}) EXPECT_LT(misfit(image, colour), 1) << colour;
    double most = 0;
    for (const float v : image.get("light_glow.R")) most = std::max(most, double(v));
    EXPECT_GE(most, 2);        // the ball itself, and what its floor sends back
    EXPECT_LT(most, 2 / 0.2);  // of a furnace of its albedo
    World plain = world_under(lights(), {2, 1, 0.2});
    plain.light_groups = {};
    EXPECT_TRUE(picture(plain).get("R") == image.get("R"));
}

TEST(Relight, OfWhatGlowsEqualsWhatIsRendered) {
    // Paths do not depend on how bright what glows is: both pictures have the same, and differ by rounding alone.
    const Vec3d before{2, 1, 0.2}, now{3, 0.5, 0};
    const Relighting mix =
        relighting(light_record(scene_of(lights(), before), 1), light_record(scene_of(lights(), now), 1));
    ASSERT_EQ(mix.reason, "");
    World old_world = world_under(lights(), before), new_world = world_under(lights(), now);
    old_world.settings.clamp = new_world.settings.clamp = 0;
    const Image image = relit(picture(old_world), mix), rendered = picture(new_world);
    for (const char* channel : {"R", "G", "B", "light_glow.R", "light_glow.G", "light_glow.B"})
        for (std::size_t i = 0; i < image.pixels(); ++i)
            ASSERT_NEAR(image.get(channel)[i], rendered.get(channel)[i], 1e-5f * (1 + rendered.get(channel)[i]))
                << channel << i;
}

TEST(Relight, TurnsAGlowOffAndNotOn) {
    const scene::Scene bright = scene_of(lights(), {2, 1, 0.2});
    scene::Scene dark = bright;
    dark.look.appearances[0].glow.strength = 0;
    const std::string with = light_record(bright, 1), without = light_record(dark, 1);
    EXPECT_EQ(relighting(without, with).reason, "its picture has no light group 'glow'");
    const Relighting mix = relighting(with, without);
    ASSERT_EQ(mix.reason, "");
    EXPECT_FALSE(mix.is_same());
    const Image before = picture(world_under(lights(), {2, 1, 0.2})), image = relit(before, mix);
    EXPECT_EQ(image.find("light_glow.R"), nullptr);
    EXPECT_NE(image.find("light_warm.R"), nullptr);
    for (std::size_t i = 0; i < image.pixels(); ++i)
        ASSERT_NEAR(image.get("R")[i], before.get("R")[i] - before.get("light_glow.R")[i], 1e-5f);
    scene::Scene other = bright;  // its light is then another in every place
    other.look.appearances[0].glow.black_body = 1200;
    EXPECT_EQ(relighting(with, light_record(other, 1)).reason, "look.appearances.ball.glow.black_body differs");
    scene::Scene two = bright;
    two.look.appearances[1].glow = bright.look.appearances[0].glow;
    EXPECT_EQ(relighting(with, light_record(two, 1)).reason, "look.appearances.matt.glow gave no light before");
}

TEST(Relight, UnchangedLightsGiveTheSamePicture) {
    const Image image = picture(world_under(lights()));
    const std::string record = light_record(scene_of(lights()), 1);
    const Image same = relit(image, relighting(record, record));
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
