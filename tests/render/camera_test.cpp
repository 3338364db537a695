#include "render/camera.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"

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
