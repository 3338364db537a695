// The solid angle of a triangle.
#pragma once

#include <cmath>

namespace thixo {

/// Half the solid angle [sr] of a triangle seen from the origin, positive from behind (Van Oosterom & Strackee 1983).
template <class V>
typename V::Scalar half_solid_angle(const V& a, const V& b, const V& c) {
    using Number = typename V::Scalar;
    const Number la = a.norm(), lb = b.norm(), lc = c.norm();
    const Number determinant = a.dot(b.cross(c));
    const Number denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    // In the triangle's own plane it is seen edge on, or is on it: the mean of both sides.
    if (determinant == 0 && denominator <= 0) return 0;
    return std::atan2(determinant, denominator);
}

}  // namespace thixo
