#include "pipeline/geometry/keyframes.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

/// Rotation vector of a unit quaternion by the shorter way, |w| <= pi.
Vec3d log_of(Quatd q) {
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const double sine = q.vec().norm();
    return sine > 1e-12 ? Vec3d(2 * std::atan2(sine, q.w()) / sine * q.vec()) : Vec3d(2 * q.vec());
}

Quatd exp_of(const Vec3d& w) {
    const double angle = w.norm();
    if (angle < 1e-12) return Quatd(1, w.x() / 2, w.y() / 2, w.z() / 2).normalized();
    const Vec3d v = std::sin(angle / 2) / angle * w;
    return Quatd(std::cos(angle / 2), v.x(), v.y(), v.z());
}

/// Velocity at a key, from the mean velocities before and after it. It is their harmonic mean where they are parallel
/// and becomes smaller with the angle between them.
Vec3d key_velocity(const Vec3d& before, const Vec3d& after) {
    const double a = before.norm(), b = after.norm();
    return a + b > 0 ? Vec3d((b * before + a * after) / (a + b)) : Vec3d::Zero();
}

/// Cumulative cubic Bernstein polynomials b1, b2, b3 at s and their derivatives. A linear segment has b2 = s alone.
struct Basis {
    Basis(double s, bool cubic) {
        if (!cubic) {
            value[1] = s, slope[1] = 1;
            return;
        }
        const double r = 1 - s;
        value[0] = 1 - r * r * r, value[1] = s * s * (3 - 2 * s), value[2] = s * s * s;
        slope[0] = 3 * r * r, slope[1] = 6 * s * r, slope[2] = 3 * s * s;
    }
    double value[3] = {0, 0, 0}, slope[3] = {0, 0, 0};
};

}  // namespace

RigidMotion::RigidMotion(std::vector<RigidKey> keys, Interpolation interpolation) : keys_(std::move(keys)) {
    for (std::size_t k = 0; k < keys_.size(); ++k) {
        RigidKey& key = keys_[k];
        if (!std::isfinite(key.time) || !key.position.allFinite() || !key.rotation.coeffs().allFinite() ||
            !(key.rotation.norm() > 0))
            throw InputError("motion key {} has a value that is not finite; check its time, position and rotation",
                             k + 1);
        if (k > 0 && !(key.time > keys_[k - 1].time))
            throw InputError("motion key {} is at {} s, key {} at {} s; times must ascend", k, keys_[k - 1].time, k + 1,
                             key.time);
        key.rotation.normalize();
    }
    if (keys_.size() < 2) return;

    const std::size_t n = keys_.size() - 1;
    std::vector<Vec3d> velocity(n), angular(n);  // means of the segments; angular in the frame of the body
    for (std::size_t k = 0; k < n; ++k) {
        const double dt = keys_[k + 1].time - keys_[k].time;
        velocity[k] = (keys_[k + 1].position - keys_[k].position) / dt;
        angular[k] = log_of(keys_[k].rotation.conjugate() * keys_[k + 1].rotation) / dt;
    }
    const auto at_key = [&](const std::vector<Vec3d>& mean, std::size_t k) {
        return k == 0 || k == n ? Vec3d::Zero() : key_velocity(mean[k - 1], mean[k]);
    };
    for (std::size_t k = 0; k < n; ++k) {
        const double dt = keys_[k + 1].time - keys_[k].time;
        const bool smooth = interpolation == Interpolation::smooth;
        const Vec3d v0 = smooth ? at_key(velocity, k) : velocity[k],
                    v1 = smooth ? at_key(velocity, k + 1) : velocity[k];
        const Vec3d w0 = smooth ? at_key(angular, k) : Vec3d::Zero(),
                    w1 = smooth ? at_key(angular, k + 1) : Vec3d::Zero();
        const Vec3d &p0 = keys_[k].position, &p1 = keys_[k + 1].position;
        const Vec3d turn0 = w0 * dt / 3, turn2 = w1 * dt / 3;
        const Vec3d turn1 =
            log_of((keys_[k].rotation * exp_of(turn0)).conjugate() * keys_[k + 1].rotation * exp_of(turn2).conjugate());
        segments_.push_back({{p0, p0 + v0 * dt / 3, p1 - v1 * dt / 3, p1}, {turn0, turn1, turn2}, smooth});
    }
}

RigidMotion RigidMotion::seen_from(const Vec3d& origin) const {
    RigidMotion moved = *this;
    moved.origin_ += origin;
    return moved;
}

// With places y = x - o, the map y -> q y + t' has t' = q o - o + t.
RigidPose RigidMotion::pose(double time) const {
    RigidPose pose = own_pose(time);
    if (!origin_.isZero()) pose.translation += pose.rotation * origin_ - origin_;
    return pose;
}

RigidVelocity RigidMotion::velocity(double time) const {
    RigidVelocity velocity = own_velocity(time);
    if (!origin_.isZero()) velocity.linear += velocity.angular.cross(own_pose(time).rotation * origin_);
    return velocity;
}

RigidPose RigidMotion::own_pose(double time) const {
    if (keys_.empty()) return {};
    if (time <= keys_.front().time) return {keys_.front().rotation, keys_.front().position};
    if (time >= keys_.back().time) return {keys_.back().rotation, keys_.back().position};
    const std::size_t k = segment_at(time);
    const Segment& seg = segments_[k];
    const double s = (time - keys_[k].time) / (keys_[k + 1].time - keys_[k].time);
    const Basis b(s, seg.cubic);
    const Quatd q = keys_[k].rotation * exp_of(seg.turn[0] * b.value[0]) * exp_of(seg.turn[1] * b.value[1]) *
                    exp_of(seg.turn[2] * b.value[2]);
    const double r = 1 - s;
    const Vec3d x = r * r * r * seg.position[0] + 3 * s * r * r * seg.position[1] + 3 * s * s * r * seg.position[2] +
                    s * s * s * seg.position[3];
    return {q.normalized(), x};
}

RigidVelocity RigidMotion::own_velocity(double time) const {
    if (keys_.size() < 2 || time < keys_.front().time || time >= keys_.back().time) return {};
    const std::size_t k = segment_at(time);
    const Segment& seg = segments_[k];
    const double dt = keys_[k + 1].time - keys_[k].time, s = (time - keys_[k].time) / dt, r = 1 - s;
    const auto& p = seg.position;
    const Vec3d linear = 3 * (r * r * (p[1] - p[0]) + 2 * s * r * (p[2] - p[1]) + s * s * (p[3] - p[2])) / dt;

    // Time derivative of the product. Each factor turns about its own fixed axis, rotated by the factors left of it.
    const Basis b(s, seg.cubic);
    Quatd left = keys_[k].rotation;
    Vec3d angular = Vec3d::Zero();
    for (int i = 0; i < 3; ++i) {
        angular += left * (seg.turn[i] * (b.slope[i] / dt));
        left = left * exp_of(seg.turn[i] * b.value[i]);
    }
    return {linear, angular};
}

std::size_t RigidMotion::segment_at(double time) const {
    const auto after =
        std::upper_bound(keys_.begin(), keys_.end(), time, [](double t, const RigidKey& key) { return t < key.time; });
    return std::min(static_cast<std::size_t>(after - keys_.begin()), keys_.size() - 1) - 1;
}

RigidMotion motion_from_degrees(const std::vector<double>& times, const std::vector<Vec3d>& positions,
                                const std::vector<Vec3d>& degrees, Interpolation interpolation) {
    if (positions.size() != times.size() || degrees.size() != times.size())
        throw InputError("motion has {} times, {} positions and {} rotations; give every key all three", times.size(),
                         positions.size(), degrees.size());
    std::vector<RigidKey> keys;
    for (std::size_t k = 0; k < times.size(); ++k) {
        if (k > 0 && (degrees[k] - degrees[k - 1]).cwiseAbs().maxCoeff() >= 180)
            throw InputError("motion keys {} and {} differ by 180 degrees or more; add a key between them", k, k + 1);
        keys.push_back({times[k], positions[k], rotation_from_degrees(degrees[k])});
    }
    return RigidMotion(std::move(keys), interpolation);
}

}  // namespace thixo
