// Small operations on axis-aligned boxes.
#pragma once

#include <cmath>

#include "pipeline/geometry/shape.h"

namespace thixo {

inline Box3 grown(const Box3& box, Real by) { return {box.lower - Vec3::Constant(by), box.upper + Vec3::Constant(by)}; }
inline Box3 joined(const Box3& a, const Box3& b) { return {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)}; }
/// The common part of two boxes, or a point of the gap between them.
inline Box3 common(const Box3& a, const Box3& b) {
    Box3 c{a.lower.cwiseMax(b.lower), a.upper.cwiseMin(b.upper)};
    for (int k = 0; k < 3; ++k)
        if (c.lower[k] > c.upper[k]) c.lower[k] = c.upper[k] = (c.lower[k] + c.upper[k]) / 2;
    return c;
}
/// The vector from the nearest place of the box to x; 0 inside.
inline Vec3 away_from(const Box3& box, const Vec3& x) { return x - x.cwiseMax(box.lower).cwiseMin(box.upper); }
/// Distance from x to the box; 0 inside.
inline Real distance_to(const Box3& box, const Vec3& x) {
    return (box.lower - x).cwiseMax(x - box.upper).cwiseMax(Real(0)).norm();
}
/// The larger of d and, outside the box, the distance to it. `slope` is that of d and becomes that of the larger.
inline Real out_of_box(const Box3& box, const Vec3& x, Real d, Vec3& slope) {
    const Vec3 away = away_from(box, x);
    const Real outside = away.norm();
    if (!(outside > 0 && outside > d)) return d;
    slope = away / outside;
    return outside;
}

}  // namespace thixo
