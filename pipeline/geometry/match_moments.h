// Weights of points that integrate as a shape does.
#pragma once

#include <algorithm>
#include <vector>

#include "pipeline/geometry/shapes.h"

namespace thixo {

/// What a unit of volume at a point stands for: its place [m], and the product of that with itself [m^2].
struct PointMoments {
    Vec3d first = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();
    double freedom = 1;  // how far its volume may change beside those of others; 0: it stays
};

/// Changes the volumes v_k of points, so that they have the moments of a shape:
///     sum v_k = V,   sum v_k first_k = int x dV,   sum v_k second_k = int x x^T dV
/// Of all such volumes, those with the least sum of squares of the changes, each over its v_k and freedom. Moments that
/// the points cannot tell apart, as across a single layer, stay as they are. No volume changes by more than three
/// quarters. Where that would be needed, all changes are scaled down. Returns that scale: 1 where all are met as far as the
/// points go. Places are from about the shape's centre. Where every point is free, the volumes may begin as shares of any
/// sum.
double match_moments(const std::vector<PointMoments>& points, const ShapeMoments& shape, std::vector<Real>& volume);

/// The same of points that stand for their own places, wherever the shape is. `freedom` may be empty: each is free then.
double match_moments(const std::vector<Vec3>& places, const std::vector<double>& freedom, const ShapeMoments& shape,
                     std::vector<Real>& volume);

/// The freedom of a point at a depth below the shape's surface, in widths of its cell. The outermost two layers share out
/// what is missing. The others keep their volumes, so that a uniform stress leaves matter within without a force.
inline double outer_freedom(double depth) { return std::clamp(2 - depth, 0.0, 1.0); }

/// Moments about another point.
ShapeMoments moments_about(const Vec3d& point, const ShapeMoments& shape);

}  // namespace thixo
