#include "render/camera.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "tests/render/worlds.h"

namespace thixo::render {
namespace {

scene::Camera camera() {
    scene::Camera c;
    c.position = {0, -2, 0};
    c.look_at = {0, 0, 0};
    c.fov = 90;
    return c;
}

TEST(Camera, TheFieldOfViewIsHorizontalAndPixelsCountFromTheTopLeft) {
    const Camera c = camera_at(camera(), 0, 200, 100);
    const Vec3f left = c.ray(0, 50, {0, 0}).direction, top = c.ray(100, 0, {0, 0}).direction;
    EXPECT_NEAR(std::atan2(-left.x(), left.y()), kPi / 4, 1e-6);
    EXPECT_NEAR(top.z() / top.y(), 0.5, 1e-6);
    EXPECT_NEAR(c.ray(100, 50, {0, 0}).direction.y(), 1, 1e-6);
}

TEST(Camera, GoesAlongItsPath) {
    scene::Camera s = camera();
    s.fov = 60;
    s.path = {{1, {0, -2, 0}, {0, 0, 0}, 0}, {2, {0, -4, 0}, {0, 0, 0}, 30}, {3, {0, -5, 0}, {0, 0, 1}, 0}};
    for (const scene::CameraKey& k : s.path) {
        const Camera at = camera_at(s, k.time, 200, 100);
        EXPECT_LT((at.position - k.position.cast<float>()).norm(), 1e-6f);
        EXPECT_LT((at.pixel(k.look_at.cast<float>()) - Vec2f(100, 50)).norm(), 1e-3f);
        EXPECT_NEAR(at.half_width, std::tan((k.fov > 0 ? k.fov : 60) * kPi / 360), 1e-6);
    }
    // Along a straight row of keys it goes straight, and beyond them it rests.
    const Camera between = camera_at(s, 1.5, 200, 100);
    EXPECT_NEAR(between.position.x(), 0, 1e-6);
    EXPECT_GT(between.position.y(), -4);
    EXPECT_LT(between.position.y(), -2);
    EXPECT_EQ(camera_at(s, 0, 200, 100).position, camera_at(s, 1, 200, 100).position);
    EXPECT_EQ(camera_at(s, 9, 200, 100).position, camera_at(s, 3, 200, 100).position);
}

TEST(Camera, BetweenTwoPlacesZoomsAndTurns) {
    scene::Camera s = camera();
    s.path = {{0, {0, -2, 0}, {0, 0, 0}, 60}, {1, {1, -2, 0}, {0, 0, 0.5}, 20}};
    const Camera from = camera_at(s, 0, 200, 100), to = camera_at(s, 1, 200, 100), half = between(from, to, 0.5f);
    EXPECT_FLOAT_EQ(half.half_width, (from.half_width + to.half_width) / 2);
    EXPECT_FLOAT_EQ(half.half_height, (from.half_height + to.half_height) / 2);
    EXPECT_FLOAT_EQ(half.position.x(), 0.5f);
    EXPECT_NEAR(half.right.dot(half.forward), 0, 1e-6);
    EXPECT_NEAR(half.down.norm(), 1, 1e-6);
    EXPECT_LT((between(from, to, 1).pixel({0, 0, 0.5f}) - to.pixel({0, 0, 0.5f})).norm(), 1e-3f);
}

TEST(Camera, OrbitsWhatItLooksAt) {
    scene::Camera s = camera();
    s.look_at = {1, 0, 0};
    s.orbit = 30;
    const Camera start = camera_at(s, 0, 200, 200), later = camera_at(s, 3, 200, 200);  // a quarter round
    EXPECT_LT((start.position - Vec3f(0, -2, 0)).norm(), 1e-6f);
    EXPECT_LT((later.position - Vec3f(3, -1, 0)).norm(), 1e-6f);
    EXPECT_LT((later.pixel({1, 0, 0}) - Vec2f(100, 100)).norm(), 1e-3f);
}

TEST(Camera, RaysOfALensMeetInTheFocus) {
    scene::Camera s = camera();
    s.aperture = 0.2;
    s.focus_distance = 3;
    const Camera c = camera_at(s, 0, 200, 100);
    for (const Vec2f& lens : {Vec2f(0.1f, 0.2f), Vec2f(0.9f, 0.3f), Vec2f(0.5f, 0.99f)}) {
        const Ray ray = c.ray(100, 50, lens);
        const float t = (1.0f - ray.origin.y()) / ray.direction.y();
        EXPECT_NEAR((ray.origin + t * ray.direction - Vec3f(0, 1, 0)).norm(), 0, 1e-5);
        EXPECT_LE((ray.origin - c.position).norm(), 0.2f + 1e-6f);
    }
}

TEST(Camera, WhatIsOutOfFocusBlursToItsCircleOfConfusion) {
    // A small lamp at distance d is spread evenly over a disc in the plane of focus. The diameter of the disc is
    //     2 aperture |d - f| / d  [m]
    // Its second moments along x and y are a sixteenth of the square of the diameter. About a thousand samples meet the
    // lamp: 5 %. The lamp's own size and the pixel filter are added.
    for (const double distance : {1.2, 3.0}) {
        World world;
        world.rays = std::make_unique<RayScene>(SurfelSet{}, std::vector<MeshObject>{});
        scene::Light lamp;
        lamp.type = scene::LightType::area;
        lamp.position = {0, distance, 0};
        lamp.direction = {0, -1, 0};
        lamp.size = {0.012 * distance, 0.012 * distance};
        world.lights = {make_light(lamp)};
        world.background = {0, 0, 0};
        scene::Camera c;
        c.position = {0, 0, 0};
        c.look_at = {0, 1, 0};
        c.fov = 20;
        c.aperture = 0.2;
        c.focus_distance = 2;
        world.camera = camera_at(c, 0, 64, 64);
        FilmSettings film;
        film.samples = 256;
        const Image image = render(world, film);
        const std::vector<float>& lit = image.get("G");
        double sum = 0, xx = 0, yy = 0;
        for (int k = 0; k < 64 * 64; ++k) {
            const double x = k % 64 - 31.5, y = k / 64 - 31.5, w = double(lit[std::size_t(k)]);
            sum += w;
            xx += w * x * x;
            yy += w * y * y;
        }
        const double pixel = 2 * std::tan(10 * kPi / 180) * 2 / 64;  // in the plane of focus
        const double circle = 2 * 0.2 * std::abs(distance - 2) / distance / pixel;
        const double own = 0.012 * 2 / pixel;  // the lamp, as wide as this many pixels
        const double expected = circle * circle / 16 + own * own / 12 + 0.2;
        EXPECT_NEAR(xx / sum / expected, 1, 0.1) << distance;
        EXPECT_NEAR(yy / sum / expected, 1, 0.1) << distance;
        EXPECT_GT(circle, 10);
    }
}

TEST(Camera, ItsMotionTurnsItAboutItself) {
    scene::Camera s = camera();
    s.motion = {{0, {0, 0, 0}, {0, 0, 0}}, {1, {0, 0, 5}, {0, 0, 90}}};
    const Camera c = camera_at(s, 1, 200, 100);
    EXPECT_LT((c.position - Vec3f(0, -2, 5)).norm(), 1e-5);
    EXPECT_LT((c.forward - Vec3f(-1, 0, 0)).norm(), 1e-5);
}

TEST(Camera, RefusesAViewWithoutADirection) {
    scene::Camera s = camera();
    s.look_at = s.position;
    EXPECT_THROW(camera_at(s, 0, 10, 10), InputError);
    s = camera();
    s.up = {0, 1, 0};
    EXPECT_THROW(camera_at(s, 0, 10, 10), InputError);
}

}  // namespace
}  // namespace thixo::render
