// The camera of a look at one instant.
#pragma once

#include "pipeline/contract/scene.h"
#include "render/ray.h"

namespace thixo::render {

/// Pinhole or thin lens; horizontal field of view. Requires width, height > 0.
struct Camera {
    Vec3f position{0, 0, 0};
    Vec3f right{1, 0, 0}, down{0, 0, -1}, forward{0, 1, 0};  // unit
    float half_width = 1, half_height = 1;                   // of the picture at distance 1
    float aperture = 0, focus = 1;                           // m
    int width = 1, height = 1;

    /// Angle of a pixel in the middle of the picture [rad].
    float pixel_angle() const { return 2 * half_width / float(width); }
    /// Through the point (x, y) in pixels from the top left; `lens` is uniform in the unit square.
    Ray ray(float x, float y, const Vec2f& lens) const;
    /// Where a point before the camera is seen, in pixels from the top left; the inverse of ray().
    Vec2f pixel(const Vec3f& point) const;
};

/// Between two places of one camera, `part` of the way: it goes straight, and turns by the shortest way.
Camera between(const Camera& from, const Camera& to, float part);

/// The camera at time [s] (camera_pose.h, which says what it throws).
Camera camera_at(const scene::Camera& camera, double time, int width, int height);

}  // namespace thixo::render
