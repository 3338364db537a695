// Constructors of shapes: primitives, solids of revolution, meshes, and their combinations and changes. Lengths are in
// metres. All of them throw InputError where a size is not finite or not positive. Sources: Hart 1996 (distance trees),
// Quilez (primitives).
#pragma once

#include <memory>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/geometry/mesh_query.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

// ---- primitives, with exact distance --------------------------------------------------------------------------------
Shape sphere(double radius);                                        // centre at the origin
Shape ellipsoid(const Vec3d& radii);                                // exact by bisection (Eberly 2013)
Shape box(const Vec3d& size, double rounding = 0);                  // edge lengths with the rounding in them; centred
Shape cylinder(double radius, double height, double rounding = 0);  // axis z, centred
Shape rounded_cone(double radius1, double radius2,
                   double height);  // two spheres and their hull, axis z from the origin
Shape capsule(const Vec3d& from, const Vec3d& to, double radius);
Shape torus(double radius, double tube);          // axis z
Shape plane(const Vec3d& normal, double offset);  // solid where n.x < offset, n = normal/|normal|; unbounded

/// A closed polygon (r >= 0, z) of either orientation, rotated about z. An edge from the last point to the first closes
/// it. Edges on the axis are no surface. Throws InputError where a point has r < 0, fewer than three points differ, or
/// the polygon crosses itself.
Shape revolve(const std::vector<Vec2d>& profile);

/// A ball swept along a smooth curve through the points, with a smoothly changing radius. The curve is cubic Hermite,
/// with tangents from both neighbours. `closed` joins the last point to the first. Throws InputError for fewer than two
/// points (closed: three), or two in one place.
struct SweepPoint {
    Vec3d at{0, 0, 0};  // m
    double radius = 0;  // m
};
Shape swept(const std::vector<SweepPoint>& points, bool closed = false);

/// A closed surface of points with outward normals, given by vertices and normals of `points`; its triangles are
/// ignored. Near the surface the distance is that to the plane of the nearest points, elsewhere that to the nearest
/// disc. The winding number of the discs gives the sign (Barill et al. 2018). A set with inward normals is inverted
/// (`orient_outward`). Throws InputError where points or normals are missing or not finite.
Shape point_shape(TriangleMesh points);

/// A triangle mesh: the distance is that to the closest triangle, and the winding number gives the sign. So holes and
/// self-intersections do no harm. Shells that are inside out and triangles wound against their neighbours are inverted
/// (`orient_outward`).
Shape mesh_shape(TriangleMesh mesh);
/// The same with a shared query structure, whose mesh must be oriented outwards.
Shape mesh_shape(std::shared_ptr<const MeshQuery> query);

// ---- combinations ---------------------------------------------------------------------------------------------------
// With smooth > 0 [m], surfaces nearer to each other than that are blended, by the quadratic polynomial minimum
//     smin(a, b) = min(a, b) - max(smooth - |a - b|, 0)^2 / (4 smooth)  [m]
// It extends a union by smooth/4 at most. Lists are folded in their order; an empty list throws InputError.
Shape union_of(std::vector<Shape> shapes, double smooth = 0);
Shape intersection_of(std::vector<Shape> shapes, double smooth = 0);
Shape difference_of(std::vector<Shape> shapes, double smooth = 0);  // the first without the others

/// The shape and its image in the plane n.x = offset [m], n = normal/|normal|.
Shape mirrored(Shape shape, const Vec3d& normal, double offset, double smooth = 0);
/// `count` copies. Copy k is rotated by k turn [degrees] about z and shifted by k step [m].
Shape repeated(Shape shape, int count, const Vec3d& step, double turn, double smooth = 0);

// ---- changes --------------------------------------------------------------------------------------------------------
Shape scaled(Shape shape, double factor);
Shape rotated(Shape shape, const Quatd& rotation);
Shape translated(Shape shape, const Vec3d& by);
/// Maps the shape by x -> rotation (factor x) + translation, in one node.
Shape transformed(Shape shape, double factor, const Quatd& rotation, const Vec3d& translation);
/// The offset of the shape, outwards where by > 0: the set distance < by.
Shape offset(Shape shape, double by);
/// A hollow shell of this thickness, inwards from the surface.
Shape shell(Shape shape, double thickness);
/// Twists the shape about z by `rate` [degrees/m] times z. The distance is a lower bound: that of the straight shape
/// over the greatest stretch.
Shape twisted(Shape shape, double rate);
/// Bends the z axis, from the shape's lowest to its highest point, into an arc of `angle` [degrees] towards +x. The
/// angle is at most 180 either way. The lowest point stays at its height. The distance is a lower bound, as for a
/// twist. Throws InputError where the inner side would fold.
Shape bent(Shape shape, double angle);
/// Raises the surface by amplitude [m] times fractal gradient noise at x / scale; negative values lower it. The
/// distance is a lower bound.
Shape roughened(Shape shape, double amplitude, double scale, int octaves);
/// The complement: outside becomes inside. It makes a room of an obstacle.
Shape inverted(Shape shape);

// ---- measures -------------------------------------------------------------------------------------------------------
/// Volume [m^3] by cells of the edge `cell` [m]. A cell whose midpoint has the distance d is filled to the part
///     clamp(1/2 - d/cell, 0, 1)
/// This is of second order for smooth surfaces. Throws InputError where the shape is unbounded.
double volume(const Shape& shape, double cell);

/// Volume [m^3], and the integrals of x [m^4] and x x^T [m^5] over it.
struct ShapeMoments {
    double volume = 0;
    Vec3d first = Vec3d::Zero();
    Mat3d second = Mat3d::Zero();
    ShapeMoments& operator+=(const ShapeMoments& b) {
        volume += b.volume;
        first += b.first;
        second += b.second;
        return *this;
    }
    ShapeMoments operator+(const ShapeMoments& b) const { return ShapeMoments(*this) += b; }
};
/// By cells as in `volume`, of the edge `cell` [m] at most, so that whole cells fill the shape's box.
ShapeMoments moments(const Shape& shape, double cell);

/// Rotation by degrees about the fixed axes x, then y, then z (as scenes give it).
Quatd rotation_from_degrees(const Vec3d& degrees);

}  // namespace thixo
