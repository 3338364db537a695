// Passes say what the geometry says.
#include "render/passes.h"

#include <gtest/gtest.h>

#include <bit>

#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

using namespace worlds;

constexpr int kWidth = 60, kHeight = 40;
constexpr float kRadius = 0.3f;
const Vec3f kCentre(0, 0, 0.3f), kVelocity(0.4f, 0, 0);

ObjectLabel label(const std::string& name, const std::string& appearance, int body) {
    ObjectLabel l;
    l.name = name;
    l.appearance = appearance;
    l.body = body;
    l.object_id = cryptomatte_id(name);
    l.material_id = cryptomatte_id(appearance);
    return l;
}

/// A ball of surfels on the ground, seen along +y; the ball moves to the right.
World ball_on_ground() {
    World world;
    scene::Appearance matt;
    const Index ball = add_object(world, matt), floor = add_object(world, matt);
    SurfelSet set = shapes::one_object(shapes::sphere(4000, kRadius, kCentre, 0.2f));
    set.object = {ball};
    set.velocity.assign(set.cloud.size(), kVelocity);
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(floor, 2));
    world.rays = std::make_unique<RayScene>(std::move(set), std::move(meshes));
    add_sky(world);
    scene::Camera camera;
    camera.position = {0, -2, 0.3};
    camera.look_at = {0, 0, 0.3};
    camera.fov = 40;
    world.camera = camera_at(camera, 0, kWidth, kHeight);
    world.neighbours = {world.camera, world.camera, 0.05f};
    world.labels = {label("ball", "clay", 7), label("floor", "wood", -1)};
    world.passes = {.position = true, .motion = true, .body = true, .sheet = true, .cryptomatte = true};
    world.attributes = true;
    return world;
}

Image picture(const World& world, int samples = 16) {
    FilmSettings film;
    film.samples = samples;
    return render(world, film);
}

std::size_t middle() { return std::size_t(kHeight / 2 * kWidth + kWidth / 2); }

TEST(Passes, ThePositionLiesOnWhatIsSeenAtItsDepth) {
    // The nearest hit gives both P and Z. On the ball, P is its radius from the centre, to a hundredth of it.
    const World world = ball_on_ground();
    const Image image = picture(world);
    int on_ball = 0;
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        const float z = image.get("Z")[i];
        if (z >= kFar) continue;
        const Vec3f p(image.get("P.X")[i], image.get("P.Y")[i], image.get("P.Z")[i]);
        EXPECT_NEAR((p - world.camera.position).dot(world.camera.forward), z, 1e-5f * z);
        if (image.get("body")[i] != 7) continue;
        ++on_ball;
        EXPECT_NEAR((p - kCentre).norm(), kRadius, 0.01f * kRadius);
    }
    EXPECT_GT(on_ball, 100);
}

TEST(Passes, WhatMovesAcrossTheViewGoesItsWayInPixels) {
    // Across the view, at depth z, a metre has
    //   width / (2 half_width z)   pixels.
    // The ball goes that much to the right in a frame and came from as far left; the ground stands. 1e-3 pixels.
    const World world = ball_on_ground();
    const Image image = picture(world);
    const std::size_t i = middle();
    const float pixels = 0.05f * kVelocity.x() * float(kWidth) / (2 * world.camera.half_width * image.get("Z")[i]);
    EXPECT_GT(pixels, 0.5f);
    EXPECT_NEAR(image.get("motion.X")[i], pixels, 1e-3f);
    EXPECT_NEAR(image.get("motion.Y")[i], 0, 1e-3f);
    EXPECT_NEAR(image.get("motion.Z")[i], -pixels, 1e-3f);
    EXPECT_NEAR(image.get("motion.W")[i], 0, 1e-3f);
    const std::size_t low = std::size_t((kHeight - 1) * kWidth + 2);
    ASSERT_EQ(image.get("body")[low], -1);
    ASSERT_LT(image.get("Z")[low], kFar);
    EXPECT_NEAR(image.get("motion.X")[low], 0, 1e-3f);
}

TEST(Passes, FacesOfCracksLookLikeTheInsideAndSayWhichTheyAre) {
    // One object of two balls: one is outer surface, the other stands for the face of a crack.
    World world = ball_on_ground();
    scene::Appearance red, blue;
    red.colour = {0.8, 0.1, 0.1};
    blue.colour = {0.1, 0.1, 0.8};
    const Index object = add_object(world, red), other = add_object(world, blue);
    world.inside_of[object] = world.material_of[other];
    SurfelSet set = shapes::one_object(shapes::sphere(2000, 0.2f, {-0.3f, 0, 0.3f}, 0.2f));
    const SurfelCloud face = shapes::sphere(2000, 0.2f, {0.3f, 0, 0.3f}, 0.2f);
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(set.cloud.position, face.position);
    append(set.cloud.axis1, face.axis1);
    append(set.cloud.axis2, face.axis2);
    append(set.cloud.normal, face.normal);
    set.layer.resize(set.cloud.size(), 1);
    set.object = {object, object};
    set.sheet = {0, kFirstCrackSheet + 3};
    world.rays = std::make_unique<RayScene>(std::move(set), std::vector<MeshObject>());
    world.labels.resize(4);
    world.settings.transparent_background = true;
    const Image image = picture(world);
    int outer = 0, inner = 0;
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        const float sheet = image.get("sheet")[i], blueness = image.get("albedo.B")[i] - image.get("albedo.R")[i];
        if (image.get("A")[i] < 1) continue;
        EXPECT_EQ(sheet, i % kWidth < kWidth / 2 ? 0 : kFirstCrackSheet + 3);
        EXPECT_NEAR(blueness, sheet > 0 ? 0.7f : -0.7f, 1e-5f);
        ++(sheet > 0 ? inner : outer);
    }
    EXPECT_GT(outer, 50);
    EXPECT_GT(inner, 50);
}

TEST(Passes, ACameraThatRisesMovesTheGroundDown) {
    World world = ball_on_ground();
    world.neighbours.after.position.z() += 0.1f;
    world.neighbours.before.position.z() -= 0.1f;
    const Image image = picture(world);
    const std::size_t low = std::size_t((kHeight - 1) * kWidth + 2);
    EXPECT_LT(image.get("motion.Y")[low], -0.1f);
    EXPECT_GT(image.get("motion.W")[low], 0.1f);
}

TEST(Passes, MattesOfAPixelAddUpToWhatCoversIt) {
    // With a transparent background alpha is the share of samples that hit something. Three layers hold six names.
    World world = ball_on_ground();
    world.settings.transparent_background = true;
    const Image image = picture(world);
    int mixed = 0;
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        float objects = 0, materials = 0;
        for (const char* layer : {"00", "01", "02"})
            for (const char* channel : {".G", ".A"}) {
                objects += image.get(std::string("CryptoObject") + layer + channel)[i];
                materials += image.get(std::string("CryptoMaterial") + layer + channel)[i];
            }
        EXPECT_NEAR(objects, image.get("A")[i], 1e-6f);
        EXPECT_NEAR(materials, image.get("A")[i], 1e-6f);
        mixed += image.get("CryptoObject00.A")[i] > 0;
    }
    EXPECT_GT(mixed, 20);  // the ball's outline before the ground
    EXPECT_EQ(std::bit_cast<std::uint32_t>(image.get("CryptoObject00.R")[middle()]), cryptomatte_id("ball"));
    EXPECT_EQ(std::bit_cast<std::uint32_t>(image.get("CryptoMaterial00.R")[middle()]), cryptomatte_id("clay"));
    EXPECT_EQ(image.get("CryptoObject00.G")[middle()], 1);
}

TEST(Passes, OnlyThoseThatAreAskedForAreWritten) {
    World world = ball_on_ground();
    world.passes = {};
    const Image plain = picture(world, 2);
    EXPECT_EQ(plain.find("P.X"), nullptr);
    EXPECT_EQ(plain.find("CryptoObject00.R"), nullptr);
    EXPECT_TRUE(plain.attributes.empty());
    EXPECT_NE(plain.find("variance.G"), nullptr);
    world.passes.cryptomatte = true;
    const Image image = picture(world, 2);
    EXPECT_EQ(image.find("P.X"), nullptr);
    EXPECT_NE(image.find("CryptoObject02.A"), nullptr);
    for (const char* channel : {"R", "N.X", "variance.B"}) EXPECT_TRUE(image.get(channel) == plain.get(channel));
}

}  // namespace
}  // namespace thixo::render
