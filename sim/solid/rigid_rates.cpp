#include "sim/solid/rigid_rates.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace thixo {

Vec3d RigidRates::spin_of(const Vec3d& momentum) const {
    constexpr double kLine = 1e-6;
    const Eigen::SelfAdjointEigenSolver<Mat3d> eigen(inertia);
    Vec3d sum(0, 0, 0);
    for (int a = 0; a < 3; ++a) {
        if (!(eigen.eigenvalues()[a] > kLine * eigen.eigenvalues()[2])) continue;
        const Vec3d axis = eigen.eigenvectors().col(a);
        sum += axis * axis.dot(momentum) / eigen.eigenvalues()[a];
    }
    return sum;
}

Turning turn_on(const RigidRates& r, double dt) {
    const Vec3d angular = r.inertia * r.spin;
    const auto about = [](const Vec3d& rotation) {
        const double angle = rotation.norm();
        return angle > 0 ? Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix() : Mat3d(Mat3d::Identity());
    };
    const Vec3d half = r.spin_of(about(dt / 2 * r.spin).transpose() * angular);
    const Mat3d turn = about(dt * half);
    const Vec3d spin = r.spin_of(turn.transpose() * angular);
    return {turn, spin, r.spin_of(-spin.cross(r.inertia * spin))};
}

}  // namespace thixo
