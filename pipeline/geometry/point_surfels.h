// Surfels from point sets: one for every point.
#pragma once

#include <vector>

#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/surfel.h"

namespace thixo {

struct PointSurfels {
    SurfelCloud surfels;
    std::vector<Vec3f> colour;  // linear; empty where the points have none
    double area = 0;            // of the surface that the points represent [m^2]
};

/// A round surfel at every point. Its radius is a tenth more than the spacing of the points around it, so that discs
/// overlap as those of sampled shapes do. The spacing is the root of the area per point, from the distance of the
/// twelfth neighbour. Throws InputError where normals are missing or zero, a number is not finite, or there are fewer
/// than 16 points.
PointSurfels surfels_of_points(const TriangleMesh& points);

/// Turns all surfels round where they face inward. They do where their signed volume about their middle is negative, if
/// they leave open at most a quarter of their area. (Of open sheets either side may be the outer one.) Returns whether
/// they were turned.
bool orient_outward(PointSurfels& points);

/// Maps the surfels by x -> rotation (factor x) + translation.
PointSurfels moved(const PointSurfels& points, double factor, const Quatd& rotation, const Vec3d& translation);

}  // namespace thixo
