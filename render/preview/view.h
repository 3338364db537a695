// Where the preview looks from: the camera of the look, or one that fits a box.
#pragma once

#include "pipeline/base/math.h"
#include "pipeline/contract/scene.h"

namespace thixo::preview {

/// A box that grows; empty while lower > upper.
struct Bounds {
    Vec3d lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
    void add(const Vec3d& x) {
        lower = lower.cwiseMin(x);
        upper = upper.cwiseMax(x);
    }
    bool empty() const { return lower.x() > upper.x(); }
    Vec3d centre() const { return 0.5 * (lower + upper); }
    double diagonal() const { return empty() ? 0 : (upper - lower).norm(); }
};

/// A pinhole camera. Pixel (x, y) of a picture, counted from the top left, sees along
///
///     forward + tan_x (2 (x + 1/2)/width - 1) right + tan_y (1 - 2 (y + 1/2)/height) up
///
/// where width and height are those of the picture [pixels].
struct View {
    Vec3d position{0, 0, 0};                              // m
    Vec3d right{1, 0, 0}, up{0, 0, 1}, forward{0, 1, 0};  // unit, orthogonal
    double tan_x = 0.36, tan_y = 0.2;                     // half the picture's width and height at distance 1
    double distance = 1;                                  // m, to what the camera looks at

    Vec3d focus() const { return position + distance * forward; }

    /// Coordinates along (right, up, -forward), as OpenGL has them.
    Vec3d to_eye(const Vec3d& x) const {
        return {(x - position).dot(right), (x - position).dot(up), -(x - position).dot(forward)};
    }
    /// Position in the picture, [0, 1] from the left and from the top. Requires a point in front of the camera.
    Vec2d project(const Vec3d& x) const;
};

/// The look's camera at a time [s]. The pose of its keys turns it about its own position and moves it. The field of
/// view is horizontal. Throws InputError where position and look_at are equal, or up is parallel to the view.
View look_view(const scene::Camera& camera, double time, int width, int height);

/// A camera that sees the sphere around the box, from the front, the left and a little above. Requires a box that is
/// not empty.
View fitting_view(const Bounds& box, int width, int height);

}  // namespace thixo::preview
