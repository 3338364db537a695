#include "render/camera.h"

#include <cmath>

#include "render/camera_pose.h"
#include "render/warp.h"

namespace thixo::render {

Camera camera_at(const scene::Camera& c, double time, int width, int height) {
    const CameraPose pose = camera_pose(c, time);
    Camera camera;
    camera.position = pose.position.cast<float>();
    const Vec3d forward = pose.to.normalized(), right = pose.to.cross(pose.up).normalized();
    camera.forward = forward.cast<float>();
    camera.right = right.cast<float>();
    camera.down = forward.cross(right).cast<float>();
    camera.half_width = float(std::tan(pose.fov * kPi / 360));
    camera.half_height = camera.half_width * float(height) / float(width);
    camera.aperture = float(c.aperture);
    camera.focus = float(c.focus_distance > 0 ? c.focus_distance : pose.to.norm());
    camera.width = width;
    camera.height = height;
    return camera;
}

Camera between(const Camera& from, const Camera& to, float part) {
    const auto mix = [&](const Vec3f& a, const Vec3f& b) { return Vec3f((1 - part) * a + part * b); };
    Camera camera = from;
    camera.position = mix(from.position, to.position);
    camera.forward = mix(from.forward, to.forward).normalized();
    camera.right = mix(from.right, to.right);
    camera.right = (camera.right - camera.right.dot(camera.forward) * camera.forward).normalized();
    camera.down = camera.forward.cross(camera.right);
    camera.focus = std::lerp(from.focus, to.focus, part);
    camera.half_width = std::lerp(from.half_width, to.half_width, part);
    camera.half_height = std::lerp(from.half_height, to.half_height, part);
    return camera;
}

Vec2f Camera::pixel(const Vec3f& point) const {
    const Vec3f to = point - position;
    const float depth = std::max(to.dot(forward), 1e-6f);
    return {0.5f * float(width) * (to.dot(right) / (depth * half_width) + 1),
            0.5f * float(height) * (to.dot(down) / (depth * half_height) + 1)};
}

Ray Camera::ray(float x, float y, const Vec2f& lens) const {
    const float u = (2 * x / float(width) - 1) * half_width, v = (2 * y / float(height) - 1) * half_height;
    Ray ray;
    const Vec3f through = forward + u * right + v * down;
    if (aperture <= 0) {
        ray.origin = position;
        ray.direction = through.normalized();
        return ray;
    }
    const Vec2f d = aperture * sample_disc(lens);
    ray.origin = position + d.x() * right + d.y() * down;
    ray.direction = (position + focus * through - ray.origin).normalized();
    return ray;
}

}  // namespace thixo::render
