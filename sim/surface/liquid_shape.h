// The body of liquid as a function of space: the colour field of the particles, cut off a little way inside the walls.
#pragma once

#include "sim/surface/liquid_points.h"

namespace thixo {

/// The colour field phi(x) = sum_j V0_j phi_j w_poly6(x - x_j, h), and other sums over the same points.
struct ColourSample {
    Real value = 0;          // phi [1]
    Vec3 gradient{0, 0, 0};  // grad phi [1/m]
    Vec3 centre{0, 0, 0};    // weighted mean of the points, relative to x [m]; zero where phi = 0
    Real lift_share = 0;     // share of the part's lift that applies here [1]
    Real lift = 0;           // height of the surface over the iso-surface [m]
    bool near_wall = false;  // an image is in reach
    Vec3 out{0, 0, 0};       // unit, from the walls of the images in reach into the room
};

/// A stored sample, and the place where it was taken.
struct ColourNote {
    ColourSample sample;
    Vec3 asked = Vec3::Constant(std::numeric_limits<Real>::max());
};

/// Depth below the surface of the body, > 0 inside.
struct DepthSample {
    Real depth = 0;          // [m]; near the surface of a flat body the distance, limited by 0.4 h deeper inside
    Vec3 gradient{0, 0, 0};  // [1], inwards
    Vec3 centre{0, 0, 0};    // of the colour field
    Real phi = 0;            // of the colour field
    bool wall = false;       // the walls, not the field, end the body here
    bool defined = false;    // false: no particle in reach
    Vec3 outward() const { return -gradient.normalized(); }
};

/// Distance in radii that surfels of a free surface and of a coat keep from their common crease: their discs must end
/// there. Coats of two walls cross each other deep inside the walls and reach up to their crease.
inline constexpr Real kFromCrease = Real(0.6);

/// The sheet of a surfel. Near a wall the body's surface has two sheets: the free surface, and the coat that lines the
/// wall wall_depth inside it. They meet in a crease that the wall hides, as coats of two walls do. A surfel belongs to
/// the sheet that its normal fits, and stays in it up to the crease.
struct SheetSample {
    bool defined = false;  // false: no particle in reach, or no slope to follow
    bool coat = false;
    Real phi = 0;  // of the colour field
    Real lift_share = 0;
    Vec3 centre{0, 0, 0};          // of the colour field, relative to x [m]
    Vec3 guide{0, 0, 0};           // the way to the sheet, one Newton step of at most half a spacing [m]
    Vec3 outward{0, 0, 0};         // unit normal of the sheet
    Real to_crease = 0;            // distance to the crease in the sheet, < 0 beyond it; +max where none is near [m]
    Vec3 towards_crease{0, 0, 0};  // unit tangent
    Real stand_off = 0;            // distance that surfels keep from it, in radii
};

/// The walls beside a surfel: the one it lines, or otherwise the nearest, and a second one where two meet.
struct WallPair {
    WallPlane first, second;
};

/// The stored walls beside a surfel: to look them up costs more than all other questions to the shape.
struct WallNote {
    WallPair walls;
    Vec3 asked = Vec3::Constant(std::numeric_limits<Real>::max());  // where
    Vec3 normal{0, 0, 0};                                           // of the surfel then
};

/// A surfel that lines no wall is inside the body where phi exceeds this.
inline constexpr Real kDeepest = Real(0.8);

/// Least slope of a depth, one across a flat surface, that a surface can follow [1]. Below it are the last of a cavity,
/// and places where two drops have just met.
inline constexpr Real kLeastSlope = Real(0.15);

/// Share of the lift that matter without dispersion has.
inline constexpr Real kLeastLiftShare = Real(0.2);

struct LiquidShape {
    const LiquidPoints& points;
    const Walls& walls;
    Real support;  // h [m]
    Real spacing;  // [m]
    Real iso;      // I: phi on the surface

    /// How far the body reaches into a wall [m]. It is more than the errors of surface and wall, and less than half of
    /// the thinnest sensible wall. Renderers see liquid against wall without a film of air between.
    Real wall_depth() const { return Real(0.15) * spacing; }

    ColourSample colour(const Vec3& x, std::int32_t component) const;
    /// The same to first order from a note. The note is renewed where x is more than 0.06 spacings from its place.
    /// Depths are then good to 0.003 spacings, slopes to 0.07 of their size.
    ColourSample colour(const Vec3& x, std::int32_t component, ColourNote& note) const;

    /// The depth is that of the colour field, bounded by the wall:
    ///     depth(x) = min((phi(x) - I + lift |grad phi|) / phi', d_wall(x) + wall_depth)      [m]
    /// phi' = 315/(256 h) is the slope of phi across the surface of a half space. To first order the depth is zero at
    /// `lift` outside of the iso-surface.
    DepthSample depth(const Vec3& x, std::int32_t component) const { return depth(x, component, iso); }
    DepthSample depth(const Vec3& x, std::int32_t component, Real iso_value) const {
        return depth_of(colour(x, component), x, iso_value);
    }
    DepthSample depth_of(const ColourSample& colour, const Vec3& x, Real iso_value) const;

    /// The wall that x is at or in, as a plane; none where no image is in reach. The look-up is half a spacing out in
    /// the room (ColourSample::out): inside a thin wall the distance is that of either side.
    WallPlane wall_plane(const Vec3& x, const ColourSample& colour) const;

    /// The walls beside a surfel at x with unit normal n. Where two walls meet, the nearest is not always the one that
    /// the surfel lines. The look-up for that one is farther from the other.
    WallPair walls_beside(const Vec3& x, const Vec3& n, std::int32_t component) const;
    /// The same from a note. The note is renewed where x is more than 0.15 spacings from its place, or n has turned by
    /// 20 degrees. On a wall with a radius of two spacings a plane is then 0.006 spacings off.
    const WallPair& walls_beside(const Vec3& x, const Vec3& n, std::int32_t component, WallNote& note) const;

    /// The sheet that a surfel at x with unit normal n belongs to. `colour` is the field at x. `beside` is read where
    /// colour.near_wall is true.
    SheetSample sheet(const ColourSample& colour, const WallPair& beside, const Vec3& x, const Vec3& n) const;
    SheetSample sheet(const Vec3& x, const Vec3& n, std::int32_t component, WallNote& note) const {
        ColourNote unused;
        return sheet(x, n, component, note, unused);
    }
    SheetSample sheet(const Vec3& x, const Vec3& n, std::int32_t component, WallNote& note, ColourNote& seen) const {
        const ColourSample c = colour(x, component, seen);
        return sheet(c, c.near_wall ? walls_beside(x, n, component, note) : WallPair{}, x, n);
    }

    /// Whether a surfel at x with unit normal n lines a wall.
    bool on_coat(const WallPlane& wall, const Vec3& x, const Vec3& n) const {
        return std::abs(wall.distance(x) + wall_depth()) < Real(0.5) * spacing && n.dot(wall.normal) < -Real(0.7071);
    }

    /// Largest principal curvature of the level set of phi at x, convex or hollow [1/m]: the largest |eigenvalue| of
    ///     P (grad grad phi) P / |grad phi|
    /// P is the projection across n. The coat of a wall is not a level set, and has zero curvature.
    Real curvature(const Vec3& x, const Vec3& n, std::int32_t component, WallNote& note) const;
    Real curvature(const Vec3& x, const Vec3& n, std::int32_t component) const {
        WallNote note;
        return curvature(x, n, component, note);
    }

    /// psi_I: moves x to the zero of depth by Newton's method. The step is halved while |depth| does not fall (2.40).
    /// Returns false where the field has no slope to follow, or the way gets longer than `reach` [m]; x then stays.
    bool project(Vec3& x, std::int32_t component, Real reach, Real iso_value) const;
    bool project(Vec3& x, std::int32_t component, Real reach) const { return project(x, component, reach, iso); }

  private:
    const LiquidPart* part(std::int32_t component) const {
        const auto k = static_cast<std::size_t>(component);
        return component >= 0 && k < points.part.size() ? &points.part[k] : nullptr;
    }
    WallPlane plane_from(const Vec3& beside) const;
    bool field_ends_first(Real field, const Vec3& field_slope, Real below_wall, const WallPlane& wall) const;
};

}  // namespace thixo
