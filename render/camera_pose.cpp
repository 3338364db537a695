#include "render/camera_pose.h"

#include "pipeline/base/error.h"
#include "pipeline/geometry/key_motion.h"

namespace thixo::render {
namespace {

/// A smooth curve through values at the keys' times. It rests before the first and after the last.
template <class Value>
Vec3d along(const std::vector<scene::CameraKey>& path, double time, Value&& value) {
    std::vector<RigidKey> keys;
    for (const scene::CameraKey& k : path) keys.push_back({.time = k.time, .position = value(k)});
    return RigidMotion(std::move(keys)).pose(time).translation;
}

/// The camera of its path at a time.
scene::Camera on_path(scene::Camera c, double time) {
    if (c.path.empty()) return c;
    const double wide = c.fov;
    c.position = along(c.path, time, [](const scene::CameraKey& k) { return k.position; });
    c.look_at = along(c.path, time, [](const scene::CameraKey& k) { return k.look_at; });
    c.fov = along(c.path, time, [&](const scene::CameraKey& k) { return Vec3d(k.fov > 0 ? k.fov : wide, 0, 0); }).x();
    return c;
}

}  // namespace

CameraPose camera_pose(const scene::Camera& given, double time) {
    const scene::Camera c = on_path(given, time);
    const Quatd round(Eigen::AngleAxisd(c.orbit * time * kPi / 180, c.up.normalized()));
    const RigidPose motion = motion_along(c.motion).pose(time);
    const Vec3d eye = c.orbit == 0 ? c.position : Vec3d(c.look_at + round * (c.position - c.look_at));
    const CameraPose pose{eye + motion.translation, motion.rotation * (c.look_at - eye), motion.rotation * c.up, c.fov};
    if (!(pose.to.norm() > 0))
        throw InputError("look.camera: position and look_at are the same point; move one of them");
    if (!(pose.to.cross(pose.up).norm() > 1e-9 * pose.to.norm() * pose.up.norm()))
        throw InputError("look.camera.up is along the view; choose another direction");
    return pose;
}

}  // namespace thixo::render
