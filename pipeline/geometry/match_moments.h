// Weights of points that integrate as a shape does.
#pragma once

#include <vector>

#include "pipeline/geometry/shapes.h"

namespace thixo {

/// What a unit of volume at a point stands for: its place [m], and the product of that with itself [m^2].
struct PointMoments {
    Vec3d first = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();
};

/// Changes the volumes v_k of points, so that they have the moments of a shape:
///     sum v_k = V,   sum v_k first_k = int x dV,   sum v_k second_k = int x x^T dV
/// Of all such volumes, those with the least sum of squares of the changes, each over its v_k. Moments that the points
/// cannot tell apart, as across a single layer, stay as they are. No volume changes by more than a half: where that
/// would be needed, all changes are scaled down, and the sum alone is met. Returns that scale: 1 where all are met as
/// far as the points go. All places are from about the shape's centre.
double match_moments(const std::vector<PointMoments>& points, const ShapeMoments& shape, std::vector<Real>& volume);

/// The same of points that stand for their own places, wherever the shape is.
double match_moments(const std::vector<Vec3>& places, const ShapeMoments& shape, std::vector<Real>& volume);

/// Moments about another point.
ShapeMoments moments_about(const Vec3d& point, const ShapeMoments& shape);

}  // namespace thixo
