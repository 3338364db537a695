// Surfaces that give light: seen, on other things, and on themselves.
#include "render/glow.h"

#include <gtest/gtest.h>

#include "render/black_body.h"
#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

using namespace worlds;

Image seen(const World& world, int samples) {
    FilmSettings film;
    film.samples = samples;
    return render(world, film);
}

scene::Appearance glowing(double strength, const Vec3d& colour = {1, 1, 1}, double albedo = 0.5) {
    scene::Appearance a;
    a.colour = Vec3d::Constant(albedo);
    a.glow.strength = strength;
    a.glow.colour = colour;
    return a;
}

World world_of(SurfelSet surfels, std::vector<MeshObject> meshes) {
    World world;
    world.rays = std::make_unique<RayScene>(std::move(surfels), std::move(meshes));
    world.background = {0, 0, 0};
    world.settings.clamp = 0;
    return world;
}

/// A flat disc of surfels that faces down. They are `spacing` apart; every centre is within the radius.
SurfelCloud disc(float radius, float height, float spacing) {
    SurfelCloud cloud;
    const int half = int(radius / spacing);
    for (int i = -half; i <= half; ++i)
        for (int j = -half; j <= half; ++j) {
            const Vec3f p(float(i) * spacing, float(j) * spacing, height);
            if (p.head<2>().norm() <= radius) shapes::add_disc(cloud, p, {0, 0, -1}, 1.2f * spacing);
        }
    return cloud;
}

/// The surfels of a sphere, turned to its inside.
SurfelCloud hollow(std::size_t n) {
    SurfelCloud cloud = shapes::sphere(n);
    std::swap(cloud.axis1, cloud.axis2);
    for (Vec3f& normal : cloud.normal) normal = -normal;
    return cloud;
}

TEST(Glow, IsSeenAsItIs) {
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(0));
    World world = world_of({}, std::move(meshes));
    add_object(world, glowing(3, {1, 0.5, 0.1}));
    look(world, {0, 0, 0.5}, {0, 0, 0}, 20, 8, 8);
    const Image image = seen(world, 4);
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        EXPECT_FLOAT_EQ(image.get("R")[i], 3.0f);
        EXPECT_FLOAT_EQ(image.get("G")[i], 1.5f);
        EXPECT_FLOAT_EQ(image.get("B")[i], 0.3f);
    }
}

TEST(Glow, OfADiscLightsAFloorByItsFormFactor) {
    constexpr float kRadius = 0.5f, kHeight = 1, kSpacing = 0.01f;
    constexpr double kStrength = 5, kAlbedo = 0.5;
    SurfelSet set = shapes::one_object(disc(kRadius, kHeight, kSpacing));
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(1));
    World world = world_of(std::move(set), std::move(meshes));
    add_object(world, glowing(kStrength, {1, 1, 1}, 0));  // black: nothing comes back to the floor
    scene::Appearance matt;
    matt.colour = Vec3d::Constant(kAlbedo);
    add_object(world, matt);
    look(world, {0, 0, 0.5}, {0, 0, 0}, 1, 16, 16);
    const Image image = seen(world, 1024);
    // Under the middle of a parallel disc: F = R^2/(R^2 + h^2), L = albedo e F. The rim of the surfels lies between
    // the last whole row of centres and the ends of the outermost surfels.
    const auto light = [&](double radius) {
        return kAlbedo * kStrength * square(radius) / (square(radius) + square(double(kHeight)));
    };
    const double error = 4 * standard_error(image), mean = mean_colour(image).y();
    EXPECT_GT(mean, light(kRadius - kSpacing) - error);
    EXPECT_LT(mean, light(kRadius + 1.2 * kSpacing) + error);
    EXPECT_LT(error, 0.05 * mean);  // so that the two say something
}

TEST(Glow, InAFurnaceAddsUpToItsGeometricSeries) {
    // e + rho e + rho^2 e + ... = e/(1 - rho) wherever one looks. What the last bounce leaves out is rho^61.
    constexpr double kStrength = 2, kAlbedo = 0.5;
    MeshObject box;
    box.object = 0;
    for (int k = 0; k < 8; ++k)
        box.mesh.vertices.push_back({k & 1 ? 1.0f : -1.0f, k & 2 ? 1.0f : -1.0f, k & 4 ? 1.0f : -1.0f});
    box.mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 7, 5}, {4, 6, 7}, {0, 5, 1}, {0, 4, 5},
                          {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 7, 3}, {1, 5, 7}};
    for (const bool surfels : {false, true}) {
        World world = world_of(surfels ? shapes::one_object(hollow(5000)) : SurfelSet{},
                               surfels ? std::vector<MeshObject>{} : std::vector{box});
        add_object(world, glowing(kStrength, {1, 1, 1}, kAlbedo));
        world.settings.max_bounces = 60;
        look(world, {0.1, 0.2, 0}, {1, 0, 0}, 60, 16, 16);
        const Image image = seen(world, 64);
        EXPECT_NEAR(mean_colour(image).y(), kStrength / (1 - kAlbedo),
                    4 * standard_error(image) + (surfels ? 0.005 : 1e-4) * kStrength)
            << surfels;
    }
}

TEST(Glow, EndsWithTheLastBounceOfAPathAsLampsDo) {
    // One scattering: e + rho e.
    World world = world_of(shapes::one_object(hollow(5000)), {});
    add_object(world, glowing(2, {1, 1, 1}, 0.25));
    world.settings.max_bounces = 1;
    look(world, {0, 0, 0}, {1, 0, 0}, 60, 8, 8);
    EXPECT_NEAR(mean_colour(seen(world, 16)).y(), 2 * 1.25, 0.005 * 2);
}

TEST(Glow, OfHeatFollowsTheTemperatureOfTheSurfels) {
    scene::Appearance lava = glowing(4, {1, 0.5, 1}, 0);
    lava.glow.black_body = 1200;
    for (const float celsius : {20.0f, 800.0f, 1200.0f, 1350.0f}) {
        SurfelSet set = shapes::one_object(disc(0.5f, 1, 0.02f));
        set.temperature.assign(set.cloud.size(), celsius);
        World world = world_of(std::move(set), {});
        add_object(world, lava);
        world.attributes = world.materials[0].reads_attributes();
        look(world, {0, 0, 0}, {0, 0, 1}, 5, 8, 8);
        const Vec3d light = mean_colour(seen(world, 2));
        const double law = black_body_xyz(double(celsius) + 273.15).y() / black_body_xyz(1473.15).y();
        // The colour halves green; with it doubled again the luminance is that of Planck's law.
        const Vec3f whole = Vec3d(light.x(), 2 * light.y(), light.z()).cast<float>();
        EXPECT_NEAR(double(luminance(whole)), 4 * law, 1e-4 * 4 * law + 1e-12) << celsius;
    }
}

TEST(Glow, IsSeenInGlassAndMirrors) {
    // A smooth conductor of reflectance one shows what glows as it is.
    scene::Appearance mirror;
    mirror.type = scene::AppearanceType::conductor;
    mirror.colour = {1, 1, 1};
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(1));
    World world = world_of(shapes::one_object(disc(1, 1, 0.02f)), std::move(meshes));
    add_object(world, glowing(3, {1, 1, 1}, 0));
    add_object(world, mirror);
    look(world, {0, 0, 0.5}, {0, 0, 0}, 5, 8, 8);
    EXPECT_NEAR(mean_colour(seen(world, 4)).y(), 3, 1e-4);
}

}  // namespace
}  // namespace thixo::render
