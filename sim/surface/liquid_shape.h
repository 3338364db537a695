// The body of liquid as a function of space: the colour field of the particles, cut off a little way inside the walls.
#pragma once

#include "sim/surface/liquid_points.h"

namespace thixo {

/// The colour field phi(x) = sum_j V0_j phi_j w_poly6(x - x_j, h) and what else is summed on the way.
struct ColourSample {
    Real value = 0;            // phi [1]
    Vec3 gradient{0, 0, 0};    // grad phi [1/m]
    Vec3 centre{0, 0, 0};      // weighted mean of the points, relative to x [m]; zero where phi = 0
    bool near_wall = false;    // an image is in reach
};

/// Depth below the surface of the body, > 0 inside.
struct DepthSample {
    Real depth = 0;            // [m]; near the surface of a flat body its distance, limited by 0.4 h deeper inside
    Vec3 gradient{0, 0, 0};    // [1], inwards
    Vec3 centre{0, 0, 0};      // of the colour field
    Real phi = 0;              // of the colour field
    bool wall = false;         // the walls, not the field, end the body here
    bool defined = false;      // false: no particle in reach
    Vec3 outward() const { return -gradient.normalized(); }
};

struct LiquidShape {
    const LiquidPoints& points;
    const Walls& walls;
    Real support;     // h [m]
    Real spacing;     // [m]
    Real iso;         // I: phi on the surface

    /// How far the body reaches into a wall [m]. More than the errors of surface and wall, less than half of the thinnest wall worth its
    /// name: renderers see liquid against wall without a film of air between.
    Real wall_depth() const { return Real(0.15) * spacing; }

    ColourSample colour(const Vec3& x, std::int32_t component) const;

    /// depth(x) = min((phi(x) - I) / phi', d_wall(x) + wall_depth), phi' = 315/(256 h) the slope of phi across the surface of a half space.
    DepthSample depth(const Vec3& x, std::int32_t component) const { return depth(x, component, iso); }
    DepthSample depth(const Vec3& x, std::int32_t component, Real iso_value) const;

    /// psi_I: moves x to the zero of depth by Newton's method, the step halved while |depth| does not fall (2.40). False where the field has no
    /// slope to follow, or the way gets longer than `reach` [m]; x is then wherever it was.
    bool project(Vec3& x, std::int32_t component, Real reach, Real iso_value) const;
    bool project(Vec3& x, std::int32_t component, Real reach) const { return project(x, component, reach, iso); }
};

}  // namespace thixo
