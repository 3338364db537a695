#include "render/preview/view.h"

#include <algorithm>
#include <cmath>

#include "render/camera_pose.h"

namespace thixo::preview {

namespace {

void aim(View& view, const Vec3d& direction, const Vec3d& up) {
    view.forward = direction.normalized();
    view.right = view.forward.cross(up).normalized();
    view.up = view.right.cross(view.forward);
}

void set_field(View& view, double horizontal_degrees, int width, int height) {
    view.tan_x = std::tan(0.5 * horizontal_degrees * kPi / 180);
    view.tan_y = view.tan_x * height / width;
}

}  // namespace

Vec2d View::project(const Vec3d& x) const {
    const Vec3d e = to_eye(x);
    return {0.5 + 0.5 * e.x() / (-e.z() * tan_x), 0.5 - 0.5 * e.y() / (-e.z() * tan_y)};
}

View look_view(const scene::Camera& camera, double time, int width, int height) {
    const render::CameraPose pose = render::camera_pose(camera, time);
    View view;
    view.position = pose.position;
    view.distance = pose.to.norm();
    aim(view, pose.to, pose.up);
    set_field(view, pose.fov, width, height);
    return view;
}

View fitting_view(const Bounds& box, int width, int height) {
    View view;
    aim(view, {0.35, 1, -0.35}, {0, 0, 1});
    set_field(view, 35, width, height);
    const double radius = std::max(0.5 * box.diagonal(), 1e-6);
    const double half_angle = std::atan(std::min(view.tan_x, view.tan_y));
    view.distance = 1.04 * radius / std::sin(half_angle);
    view.position = box.centre() - view.distance * view.forward;
    return view;
}

}  // namespace thixo::preview
