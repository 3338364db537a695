// Constructors of shapes: primitives, solids of revolution, meshes, and what combines and changes them. Lengths in
// metres. All of them throw InputError where a size is not finite or not positive. Sources: Hart 1996 (distance trees),
// Quilez (primitives).
#pragma once

#include <memory>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/geometry/mesh_query.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

// ---- primitives: exact distance
// ---------------------------------------------------------------------------------------------------
Shape sphere(double radius);                                        // centre at the origin
Shape ellipsoid(const Vec3d& radii);                                // exact by bisection (Eberly 2013)
Shape box(const Vec3d& size, double rounding = 0);                  // edge lengths with the rounding in them; centred
Shape cylinder(double radius, double height, double rounding = 0);  // axis z, centred
Shape rounded_cone(double radius1, double radius2,
                   double height);  // two spheres and their hull, axis z from the origin
Shape capsule(const Vec3d& from, const Vec3d& to, double radius);
Shape torus(double radius, double tube);          // axis z
Shape plane(const Vec3d& normal, double offset);  // solid where normal.x < offset; unbounded

/// A closed polygon (r >= 0, z) turned about z; the edge from the last point to the first closes it, edges on the axis
/// are no surface. Either orientation. Throws InputError where a point has r < 0, fewer than three points differ, or
/// the polygon crosses itself.
Shape revolve(const std::vector<Vec2d>& profile);

/// A ball that runs along a smooth curve through the points (cubic Hermite, tangents from both neighbours), its radius
/// running with it. `closed` joins the last point to the first. Throws InputError for fewer than two points (closed:
/// three), or two in one place.
struct SweepPoint {
    Vec3d at{0, 0, 0};  // m
    double radius = 0;  // m
};
Shape swept(const std::vector<SweepPoint>& points, bool closed = false);

/// A closed surface of points with outward normals (vertices and normals of `points`; triangles are not looked at):
/// distance to the plane of the nearest points where it is small, to the nearest disc elsewhere, sign by the winding
/// number of the discs (Barill et al. 2018). A set whose normals point inward is turned round (`orient_outward`).
/// Throws InputError where points or normals are missing or not finite.
Shape point_shape(TriangleMesh points);

/// A triangle mesh: distance to the closest triangle, sign by the winding number, so that holes and self-intersections
/// do no harm. Shells that are inside out and triangles wound against their neighbours are turned round
/// (`orient_outward`).
Shape mesh_shape(TriangleMesh mesh);
/// The same, sharing a query structure; its mesh must be oriented outwards.
Shape mesh_shape(std::shared_ptr<const MeshQuery> query);

// ---- combinations
// -----------------------------------------------------------------------------------------------------------------
// smooth > 0 [m] blends where two surfaces are nearer than that, by the quadratic polynomial minimum
//   smin(a, b) = min(a, b) - max(smooth - |a - b|, 0)^2 / (4 smooth)
// which grows a union by smooth/4 at most; lists are folded in their order. They throw InputError on an empty list.
Shape union_of(std::vector<Shape> shapes, double smooth = 0);
Shape intersection_of(std::vector<Shape> shapes, double smooth = 0);
Shape difference_of(std::vector<Shape> shapes, double smooth = 0);  // the first less all others

/// The shape and its image in the plane normal.x = offset [m].
Shape mirrored(Shape shape, const Vec3d& normal, double offset, double smooth = 0);
/// `count` copies: copy k is turned by k turn [degrees] about z and shifted by k step [m].
Shape repeated(Shape shape, int count, const Vec3d& step, double turn, double smooth = 0);

// ---- changes
// ----------------------------------------------------------------------------------------------------------------------
Shape scaled(Shape shape, double factor);
Shape rotated(Shape shape, const Quatd& rotation);
Shape translated(Shape shape, const Vec3d& by);
/// x -> rotation (factor x) + translation, in one node.
Shape transformed(Shape shape, double factor, const Quatd& rotation, const Vec3d& translation);
/// Grown (by > 0) or shrunk by a distance: the set distance < by.
Shape offset(Shape shape, double by);
/// A hollow shell of this thickness, inwards from the surface.
Shape shell(Shape shape, double thickness);
/// Turned about z by `rate` [degrees/m] times z. The distance is that of the straight shape over the greatest stretch,
/// a lower bound.
Shape twisted(Shape shape, double rate);
/// The z axis from the shape's lowest to its highest point bent into an arc of `angle` [degrees] towards +x, at most
/// 180 either way; the lowest point's height stays. A lower bound as above. Throws InputError where the inner side
/// would fold.
Shape bent(Shape shape, double angle);
/// The surface raised by amplitude [m] times fractal gradient noise at x / scale, negative amounts pressed in. A lower
/// bound.
Shape roughened(Shape shape, double amplitude, double scale, int octaves);
/// The complement: outside becomes inside. Turns an obstacle into a room.
Shape inverted(Shape shape);

// ---- measures
// ---------------------------------------------------------------------------------------------------------------------
/// Volume [m^3] by midpoints of cells of edge `cell` [m], each filled by clamp(1/2 - d/cell): second order for smooth
/// surfaces. Throws InputError where the shape is unbounded.
double volume(const Shape& shape, double cell);

/// Rotation by degrees about the fixed axes x, then y, then z (as scenes give it).
Quatd rotation_from_degrees(const Vec3d& degrees);

}  // namespace thixo
