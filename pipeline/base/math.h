// Scalars and small dense types. Real is the type of simulation state and of geometry evaluated by it.
#pragma once

#include <Eigen/Dense>
#include <cstdint>

namespace thixo {

#ifdef THIXO_DOUBLE
using Real = double;  // the build for tests of laws
#else
using Real = float;
#endif

using Vec2 = Eigen::Matrix<Real, 2, 1>;
using Vec3 = Eigen::Matrix<Real, 3, 1>;
using Mat3 = Eigen::Matrix<Real, 3, 3>;

// Types that are the same in every build: scenes hold double, caches hold float.
using Vec2f = Eigen::Vector2f;
using Vec3f = Eigen::Vector3f;
using Vec2d = Eigen::Vector2d;
using Vec3d = Eigen::Vector3d;
using Mat3d = Eigen::Matrix3d;
using Mat3f = Eigen::Matrix3f;
using Quatd = Eigen::Quaterniond;

/// Index of a particle, surfel or vertex. Scenes have at most 2^31 of each.
using Index = std::uint32_t;
inline constexpr Index kNone = 0xffffffffu;

inline constexpr double kPi = 3.14159265358979323846;

template <class T>
constexpr T square(T a) {
    return a * a;
}
template <class T>
constexpr T cube(T a) {
    return a * a * a;
}
template <class T>
constexpr T clamp01(T a) {
    return a < T(0) ? T(0) : (a > T(1) ? T(1) : a);
}

/// Two unit vectors that make a right-handed frame (a, b, n) with the unit vector n (Duff et al. 2017, branchless
/// form).
template <class V>
void orthonormal_basis(const V& n, V& a, V& b) {
    using T = typename V::Scalar;
    const T sign = std::copysign(T(1), n.z());
    const T p = T(-1) / (sign + n.z());
    const T q = n.x() * n.y() * p;
    a = V(T(1) + sign * n.x() * n.x() * p, sign * q, -sign * n.x());
    b = V(q, sign + n.y() * n.y() * p, -n.y());
}

}  // namespace thixo
