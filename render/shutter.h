// While the shutter is open: the time of a ray, and where moving things are then.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>

#include "pipeline/base/math.h"

namespace thixo::render {

/// A ray's time goes from 0, as the shutter opens, to 1, as it closes.
struct Shutter {
    float open = 0, close = 0;  // from the frame's own time [s]; equal: nothing moves in the picture

    bool moves() const { return close > open; }
    /// From the frame's own time to a ray's [s].
    float seconds(float time) const { return open + time * (close - open); }
    /// The ray's time that is nearest to the frame's own.
    float frame_time() const { return moves() ? std::clamp(-open / (close - open), 0.0f, 1.0f) : 0.0f; }
};

/// Goes on as it moves at the frame's own time.
struct SteadyMotion {
    Vec3f pivot{0, 0, 0};                       // [m]
    Vec3f velocity{0, 0, 0}, angular{0, 0, 0};  // of the pivot [m/s], about it [rad/s]

    bool still() const { return velocity.isZero(0) && angular.isZero(0); }
    Mat3f turn(float seconds) const {
        const float angle = seconds * angular.norm();
        return angle == 0 ? Mat3f(Mat3f::Identity())
                          : Eigen::AngleAxisf(angle, angular.normalized()).toRotationMatrix();
    }
    Vec3f moved(const Vec3f& x, float seconds) const {
        return pivot + seconds * velocity + turn(seconds) * (x - pivot);
    }
    /// Where what is at x `seconds` later is at the frame's own time.
    Vec3f before(const Vec3f& x, float seconds) const {
        return pivot + turn(seconds).transpose() * (x - pivot - seconds * velocity);
    }
};

/// x turned about the vector `by` by twice the arc tangent of half its length: that length, less a twelfth of its cube
/// [rad]. A rotation always, without sines (Cayley): x + 2/(1 + q.q) (q x x + q x (q x x)), q = by/2.
template <class V>
void turn_by(const V (&by)[3], V (&x)[3]) {
    V q[3], once[3], twice[3];
    for (int k = 0; k < 3; ++k) q[k] = by[k] * 0.5f;
    const auto cross = [&](const V(&v)[3], V(&out)[3]) {
        for (int k = 0; k < 3; ++k) out[k] = q[(k + 1) % 3] * v[(k + 2) % 3] - q[(k + 2) % 3] * v[(k + 1) % 3];
    };
    cross(x, once);
    cross(once, twice);
    const V factor = 2.0f / (1.0f + q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
    for (int k = 0; k < 3; ++k) x[k] = x[k] + factor * (once[k] + twice[k]);
}

/// The velocity of matter about a place, to first order: v(x) = velocity + gradient (x - centre).
struct AffineVelocity {
    Vec3f centre{0, 0, 0}, velocity{0, 0, 0};  // [m], [m/s]
    Mat3f gradient = Mat3f::Zero();            // [1/s]

    /// How fast it turns [rad/s].
    Vec3f angular() const {
        return 0.5f *
               Vec3f(gradient(2, 1) - gradient(1, 2), gradient(0, 2) - gradient(2, 0), gradient(1, 0) - gradient(0, 1));
    }
    /// Where matter that is at x `seconds` later is at the frame's own time.
    Vec3f before(const Vec3f& x, float seconds) const {
        return centre + (Mat3f::Identity() + seconds * gradient).inverse() * (x - centre - seconds * velocity);
    }
};

}  // namespace thixo::render
