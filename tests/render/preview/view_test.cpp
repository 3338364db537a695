#include "render/preview/view.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"

namespace thixo::preview {
namespace {

constexpr double kRoundOff = 1e-12;  // a handful of double operations on numbers near one

scene::Camera camera_at(const Vec3d& position, const Vec3d& look_at) {
    scene::Camera camera;
    camera.position = position;
    camera.look_at = look_at;
    camera.fov = 60;
    return camera;
}

TEST(View, SeesLookAtInTheMiddleAndTheFieldAtTheEdges) {
    const View view = look_view(camera_at({0, -2, 0}, {0, 0, 0}), 0, 200, 100);
    EXPECT_NEAR((view.project({0, 0, 0}) - Vec2d(0.5, 0.5)).norm(), 0, kRoundOff);
    const double half = 2 * std::tan(30 * kPi / 180);  // horizontal field of 60 degrees at distance 2
    EXPECT_NEAR((view.project({half, 0, 0}) - Vec2d(1, 0.5)).norm(), 0, kRoundOff);
    EXPECT_NEAR((view.project({0, 0, half / 2}) - Vec2d(0.5, 0)).norm(), 0,
                kRoundOff);  // half as high as wide; up is the top
}

TEST(View, KeysTurnTheCameraAboutItsOwnPlaceAndMoveIt) {
    scene::Camera camera = camera_at({0, -2, 0}, {0, 0, 0});
    camera.motion = {{0, {0, 0, 0}, {0, 0, 0}}, {1, {3, 0, 0}, {0, 0, 90}}};
    const View before = look_view(camera, -1, 100, 100), after = look_view(camera, 2, 100, 100);
    EXPECT_NEAR((before.forward - Vec3d(0, 1, 0)).norm(), 0, kRoundOff);
    EXPECT_NEAR((after.position - Vec3d(3, -2, 0)).norm(), 0, kRoundOff);
    EXPECT_NEAR((after.forward - Vec3d(-1, 0, 0)).norm(), 0, kRoundOff);  // +y turned by 90 degrees about z
}

TEST(View, RefusesACameraWithoutADirection) {
    EXPECT_THROW(look_view(camera_at({1, 1, 1}, {1, 1, 1}), 0, 10, 10), InputError);
    EXPECT_THROW(look_view(camera_at({0, 0, 5}, {0, 0, 0}), 0, 10, 10), InputError);  // along up
}

TEST(View, FittedOneSeesTheWholeBox) {
    for (const auto& [width, height] : {std::pair{320, 180}, {180, 320}}) {
        Bounds box;
        box.add({-1, 4, 2});
        box.add({5, 4.5, 2.2});
        const View view = fitting_view(box, width, height);
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3d x(corner & 1 ? box.lower.x() : box.upper.x(), corner & 2 ? box.lower.y() : box.upper.y(),
                          corner & 4 ? box.lower.z() : box.upper.z());
            EXPECT_LT(view.to_eye(x).z(), 0);
            EXPECT_GT(view.project(x).minCoeff(), 0);
            EXPECT_LT(view.project(x).maxCoeff(), 1);
        }
    }
}

}  // namespace
}  // namespace thixo::preview
