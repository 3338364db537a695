// Light: analytic irradiances, a furnace, and ways to sample that agree.
#include "render/path.h"

#include <gtest/gtest.h>

#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

using namespace worlds;
using scene::AppearanceType;

Image picture(const World& world, int samples, Strategy strategy = Strategy::both) {
    FilmSettings film;
    film.samples = samples;
    film.strategy = strategy;
    return render(world, film);
}

/// A matt ground of albedo one half, seen from close above its middle.
World matt_ground(const Vec3d& eye = {0, 0, 0.5}) {
    World world;
    scene::Appearance matt;
    matt.colour = {0.5, 0.5, 0.5};
    const Index object = add_object(world, matt);
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(object));
    world.rays = std::make_unique<RayScene>(SurfelSet{}, std::move(meshes));
    look(world, eye, {0, 0, 0}, 1, 8, 8);
    world.settings.clamp = 0;
    return world;
}

TEST(Path, ASkyOfOneLightsAMattGroundToItsAlbedo) {
    World world = matt_ground();
    add_sky(world);
    // E = pi, L = albedo E / pi. Cosine sampling of an even sky has no variance at all.
    EXPECT_NEAR(mean_colour(picture(world, 16)).y(), 0.5, 1e-4);
}

TEST(Path, ASunGivesItsIrradianceTimesTheCosine) {
    World world = matt_ground();
    scene::Light sun;
    sun.type = scene::LightType::sun;
    sun.strength = 3;
    sun.angle = 4;
    sun.direction = {1, 0, -1};  // 45 degrees
    world.lights = {make_light(sun)};
    // E is meant at normal incidence: L = albedo E cos / pi; the disc's cosines average to that of its centre.
    EXPECT_NEAR(mean_colour(picture(world, 64)).y(), 0.5 * 3 * std::sqrt(0.5) / kPi, 2e-3);
}

TEST(Path, APointLightsAMattGroundWithoutNoise) {
    World world = matt_ground();
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0, 0, 2};
    lamp.strength = 8;
    world.lights = {make_light(lamp)};
    // E = I/d^2, L = albedo E/pi. The picture is a degree wide: 2e-5 of the light is lost at its corners.
    const Image image = picture(world, 4);
    EXPECT_NEAR(mean_colour(image).y(), 0.5 * 2 / kPi, 1e-4);
    EXPECT_LT(standard_error(image), 1e-5);
}

TEST(Path, ABallStandsInTheLightOfAPoint) {
    World world = matt_ground();
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {0, 0, 2};
    world.lights = {make_light(lamp)};
    world.rays = std::make_unique<RayScene>(shapes::one_object(shapes::sphere(2000, 0.2f, {0, 0, 1})),
                                            std::vector{ground(add_object(world, {}))});
    // What the ground has without the ball is 0.5/(4 pi). A little comes round by the ball's own lower side.
    EXPECT_LT(mean_colour(picture(world, 4)).y(), 0.05 * 0.5 / (4 * kPi));
}

TEST(Path, ARectangleGivesTheFormFactorOfItsPlace) {
    World world = matt_ground();
    scene::Light lamp;
    lamp.type = scene::LightType::area;
    lamp.position = {0, 0, 2};
    lamp.size = {2, 2};
    lamp.strength = 5;
    world.lights = {make_light(lamp)};
    // Point under the centre of a parallel rectangle: four quarters of 1/(2 pi) [a/sqrt(1+a^2) atan(b/sqrt(1+a^2)) +
    // the same swapped], a = b = 1/2.
    const double s = std::sqrt(1.25), quarter = 2 * (0.5 / s * std::atan(0.5 / s)) / (2 * kPi);
    const Image image = picture(world, 256);
    EXPECT_NEAR(mean_colour(image).y(), 0.5 * 5 * 4 * quarter, 4 * standard_error(image) + 1e-3);
}

class WaysToSampleLight : public testing::TestWithParam<double> {};
TEST_P(WaysToSampleLight, Agree) {
    // A plastic floor, bright or dark, with a lamp so near that neither way alone is good. The three means lie within
    // five of their joint standard errors.
    World world;
    scene::Appearance plastic;
    plastic.type = AppearanceType::plastic;
    plastic.roughness = 0.3;
    plastic.colour = Vec3d::Constant(GetParam());
    const Index object = add_object(world, plastic);
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(object));
    world.rays =
        std::make_unique<RayScene>(shapes::one_object(shapes::sphere(500, 0.3f, {0.3f, 0, 0.3f})), std::move(meshes));
    scene::Light lamp;
    lamp.type = scene::LightType::area;
    lamp.position = {0, 0.5, 0.8};
    lamp.size = {0.7, 0.7};
    lamp.strength = 4;
    world.lights = {make_light(lamp)};
    add_sky(world, 0.2);
    world.settings.clamp = 0;
    look(world, {0, -1, 1}, {0, 0, 0.1}, 40, 32, 18);
    const Image both = picture(world, 64), lights = picture(world, 256, Strategy::lights),
                surfaces = picture(world, 256, Strategy::surfaces);
    EXPECT_NEAR(mean_colour(both).y(), mean_colour(lights).y(),
                5 * std::hypot(standard_error(both), standard_error(lights)));
    EXPECT_NEAR(mean_colour(both).y(), mean_colour(surfaces).y(),
                5 * std::hypot(standard_error(both), standard_error(surfaces)));
    EXPECT_LT(standard_error(both), 2 * standard_error(surfaces))
        << "joining them must not add noise: a quarter of the samples, twice the error";
}

INSTANTIATE_TEST_SUITE_P(Path, WaysToSampleLight, testing::Values(0.8, 0.1));

World furnace(const scene::Appearance& appearance, bool straight, bool environment = false) {
    World world;
    const Index object = add_object(world, appearance);
    SurfelSet set = shapes::one_object(shapes::sphere(1000, 0.5f));
    set.object = {object};
    world.rays = std::make_unique<RayScene>(std::move(set), std::vector<MeshObject>());
    if (environment) {
        scene::Light light;
        light.type = scene::LightType::environment;
        world.lights = {
            make_light(light, std::make_shared<const Environment>(16, 8, std::vector<Vec3f>(128, Vec3f::Ones())))};
    } else {
        add_sky(world);
    }
    look(world, {0, 0, 3}, {0, 0, 0}, 16, 24, 24);
    world.settings = {200, straight, 0, false};
    return world;
}

TEST(Path, EveryWhiteThingVanishesInAWhiteFurnace) {
    // The picture is one everywhere, to 1 % in the mean of each; long paths are let run.
    scene::Appearance a;
    a.colour = {1, 1, 1};
    for (const AppearanceType type :
         {AppearanceType::diffuse, AppearanceType::plastic, AppearanceType::conductor, AppearanceType::dielectric})
        for (const double roughness : {0.0, 0.4}) {
            a.type = type;
            a.roughness = roughness;
            for (const bool environment : {false, true}) {
                const Image image = picture(furnace(a, true, environment), environment ? 128 : 32);
                EXPECT_NEAR(mean_colour(image).y(), 1, 0.01) << int(type) << " " << roughness << " " << environment;
            }
        }
}

TEST(Path, AWhiteMattThingInAWhiteFurnaceHasNoNoise) {
    // Whatever a direction meets, the sky or the thing itself, it brings a radiance of one: no path may differ by more
    // than rounding, 1e-4.
    scene::Appearance a;
    a.colour = {1, 1, 1};
    World world;
    const Index object = add_object(world, a);
    SurfelSet set = shapes::one_object(shapes::torus(2000, 0.5f, 0.2f));
    set.object = {object};
    std::vector<MeshObject> meshes;
    meshes.push_back(ground(add_object(world, a)));
    for (Vec3f& v : meshes[0].mesh.vertices) v.z() = -0.3f;
    world.rays = std::make_unique<RayScene>(std::move(set), std::move(meshes));
    add_sky(world);
    look(world, {0, 0, 3}, {0, 0, 0}, 30, 24, 24);
    world.settings = {10000, true, 0, false};
    const Image image = picture(world, 4);
    for (const float g : image.get("G")) EXPECT_NEAR(g, 1, 1e-4f);
}

/// A wide slab of a dielectric, its faces at z = 0 and z = -depth.
MeshObject slab(Index object, float depth) {
    constexpr float half = 100;
    MeshObject s;
    s.mesh.vertices = {{-half, -half, 0},      {half, -half, 0},      {half, half, 0},      {-half, half, 0},
                       {-half, -half, -depth}, {half, -half, -depth}, {half, half, -depth}, {-half, half, -depth}};
    s.mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
    s.object = object;
    s.solid = true;
    return s;
}

TEST(Path, AMattFloorUnderGlassVanishesInAWhiteFurnaceWithStraightShadowsOrWithout) {
    // Straight shadows move light from refracted paths to shadow rays. Under a plane face no light is made or lost:
    // each direction outside brings (1 - F) of its flux either way. Both ways follow the light that is reflected
    // inside. 1 %.
    for (const bool straight : {true, false}) {
        World world;
        scene::Appearance glass, matt;
        glass.type = AppearanceType::dielectric;
        matt.colour = {1, 1, 1};
        std::vector<MeshObject> meshes;
        meshes.push_back(slab(add_object(world, glass), 0.2f));
        MeshObject floor = ground(add_object(world, matt), 100);
        for (Vec3f& v : floor.mesh.vertices) v.z() = -0.1f;  // within the slab
        meshes.push_back(std::move(floor));
        world.rays = std::make_unique<RayScene>(SurfelSet{}, std::move(meshes));
        add_sky(world);
        look(world, {0, 0, 3}, {0, 0, 0}, 16, 24, 24);
        world.settings = {1000, straight, 0, false};
        EXPECT_NEAR(mean_colour(picture(world, 64)).y(), 1, 0.01) << straight;
    }
}

TEST(Path, TotalReflectionsGuideLightThroughALongRod) {
    // Seen obliquely through its end, a rod passes the light of a white furnace on by some forty total reflections.
    World world;
    scene::Appearance glass;
    glass.type = AppearanceType::dielectric;
    glass.ior = 1.5;
    MeshObject rod;
    rod.object = add_object(world, glass);
    rod.solid = true;
    for (const float x : {0.0f, 2.0f})
        for (const float y : {-0.02f, 0.02f})
            for (const float z : {-0.02f, 0.02f}) rod.mesh.vertices.emplace_back(x, y, z);
    rod.mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                          {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    std::vector<MeshObject> meshes;
    meshes.push_back(std::move(rod));
    world.rays = std::make_unique<RayScene>(SurfelSet{}, std::move(meshes));
    add_sky(world);
    look(world, {-0.5, 0.3, 0.5}, {0, 0, 0}, 0.5, 16, 16);
    world.settings = {8, false, 0, false};
    const Image image = picture(world, 64);
    EXPECT_NEAR(mean_colour(image).y(), 1, 0.01);
}

TEST(Path, TheClampLimitsOnlyIndirectLight) {
    World world = matt_ground();
    scene::Light lamp;
    lamp.type = scene::LightType::area;
    lamp.position = {0, 0, 2};
    lamp.strength = 500;
    world.lights = {make_light(lamp)};
    const double free = mean_colour(picture(world, 64)).y();
    world.settings.clamp = 0.1f;
    EXPECT_NEAR(mean_colour(picture(world, 64)).y(), free, 0.01 * free);
}

TEST(Path, AbsorptionFollowsBeerAndLambert) {
    // A ray goes straight down through a slab of water with white furnaces on both sides. Fresnel's law holds at two
    // faces, with all reflections between them. The parts of the far and of the near furnace are
    //     T (1 - R)^2/(1 - R^2 T^2)
    //     R (1 + T^2 (1 - R)^2/(1 - R^2 T^2))
    World world;
    scene::Appearance water;
    water.type = AppearanceType::dielectric;
    water.ior = 1.33;
    water.absorption = {3, 3, 3};
    const Index object = add_object(world, water);
    std::vector<MeshObject> meshes;
    meshes.push_back(slab(object, 0.4f));
    world.rays = std::make_unique<RayScene>(SurfelSet{}, std::move(meshes));
    add_sky(world);
    look(world, {0, 0, 5}, {0, 0, 0}, 1, 16, 16);
    world.settings = {100, true, 0, false};
    const double R = square(0.33 / 2.33), T = std::exp(-3 * 0.4), many = square(1 - R) / (1 - R * R * T * T);
    const Image image = picture(world, 64);
    EXPECT_NEAR(mean_colour(image).y(), T * many + R * (1 + T * T * many), 4 * standard_error(image) + 1e-3);
}

}  // namespace
}  // namespace thixo::render
