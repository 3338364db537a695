#include "render/preview/view.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/keyframes.h"

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
    std::vector<double> times;
    std::vector<Vec3d> positions, degrees;
    for (const scene::Key& key : camera.motion) {
        times.push_back(key.time);
        positions.push_back(key.position);
        degrees.push_back(key.rotate);
    }
    const RigidPose pose = motion_from_degrees(times, positions, degrees).pose(time);
    const Vec3d direction = camera.look_at - camera.position;
    if (!(direction.norm() > 0) || !(direction.cross(camera.up).norm() > 1e-9 * direction.norm() * camera.up.norm()))
        throw InputError(
            "look: camera: position, look_at and up give no view; move look_at away from position and from the up "
            "axis");
    View view;
    view.position = camera.position + pose.translation;
    view.distance = direction.norm();
    aim(view, pose.rotation * direction, pose.rotation * camera.up);
    set_field(view, camera.fov, width, height);
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
