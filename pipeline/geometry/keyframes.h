// Rigid motion along keyframes, with its exact velocity.
#pragma once

#include <vector>

#include "pipeline/base/math.h"

namespace thixo {

struct RigidKey {
    double time = 0;                     // s
    Vec3d position{0, 0, 0};             // m
    Quatd rotation = Quatd::Identity();  // unit
};

/// The map x -> rotation x + translation.
struct RigidPose {
    Quatd rotation = Quatd::Identity();
    Vec3d translation{0, 0, 0};
    Vec3d apply(const Vec3d& x) const { return rotation * x + translation; }
    Vec3d apply_inverse(const Vec3d& x) const { return rotation.conjugate() * (x - translation); }
};

/// Velocity of the body's origin (the image of x = 0) and angular velocity, both in the world frame. A material point
/// at y has the velocity
///     linear + angular x (y - translation)  [m/s]
struct RigidVelocity {
    Vec3d linear{0, 0, 0};   // m/s
    Vec3d angular{0, 0, 0};  // rad/s
};

/// How a motion runs between keys. linear: velocities are constant and jump at keys. smooth: velocities are continuous.
/// They are zero at the first and last key and at a key that has the same place as a neighbouring one. A straight row
/// of keys is never overshot.
enum class Interpolation { linear, smooth };

/// Motion along keys. The body is at rest before the first key and after the last. Without keys it is the identity.
///
/// Smooth positions are cubic Hermite curves. With the mean velocities d0 before and d1 after a key, its tangent is
///     m = (|d1| d0 + |d0| d1)/(|d0| + |d1|)  [m/s]
/// Where d0 and d1 are parallel this is their harmonic mean (Fritsch & Butland 1984). Smooth rotations are Hermite
/// quaternion curves (Kim, Kim & Shin 1995); the same rule gives the angular velocities at keys. Between two keys a
/// rotation takes the shorter way, at most 180 degrees.
class RigidMotion {
  public:
    RigidMotion() = default;
    /// Throws InputError where times do not ascend strictly or a value is not finite.
    explicit RigidMotion(std::vector<RigidKey> keys, Interpolation interpolation = Interpolation::smooth);

    /// The same motion where places count from `origin` [m] of the frame that the keys are given in.
    RigidMotion seen_from(const Vec3d& origin) const;

    RigidPose pose(double time) const;
    /// Exact time derivative of pose. At a jump of a linear motion it is that of the segment that begins there.
    RigidVelocity velocity(double time) const;
    bool moves() const { return keys_.size() > 1; }
    const std::vector<RigidKey>& keys() const { return keys_; }

  private:
    struct Segment {        // between keys k and k+1, s in [0, 1]
        Vec3d position[4];  // Bezier points
        // With cumulative cubic Bernstein polynomials b1, b2, b3; a linear segment has turn1 alone, with b2 = s:
        //     rotation(s) = rotation_k exp(turn0 b1(s)) exp(turn1 b2(s)) exp(turn2 b3(s))
        Vec3d turn[3];
        bool cubic = true;
    };
    std::size_t segment_at(double time) const;
    RigidPose own_pose(double time) const;
    RigidVelocity own_velocity(double time) const;

    Vec3d origin_{0, 0, 0};
    std::vector<RigidKey> keys_;
    std::vector<Segment> segments_;
};

/// Keys with rotations in degrees about the fixed axes x, then y, then z. Throws InputError where an angle changes by
/// 180 degrees or more between two keys, because the direction of the turn would be lost.
RigidMotion motion_from_degrees(const std::vector<double>& times, const std::vector<Vec3d>& positions,
                                const std::vector<Vec3d>& degrees, Interpolation interpolation = Interpolation::smooth);

}  // namespace thixo
