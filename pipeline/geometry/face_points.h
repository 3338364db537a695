// Random points on the faces of a solid, even by area: what sampling chooses from.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/geometry/direct_surface.h"
#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {

/// A face: by its distance, and where it is made of a surface, that.
struct Face {
    SlopedShape shape;
    std::shared_ptr<const DirectSurface> surface;
    Real distance(const Vec3& x) const { return shape.distance(x); }
    Vec3 gradient(const Vec3& x, Real step) const { return shape.gradient(x, step); }
};

/// A solid taken apart: the shape, its faces, and the tree over their numbers, without differences. Faces of many parts
/// that surfels `spacing` [m] apart will ask are made quick (by_blocks).
struct FacedSolid {
    FacedSolid(const Shape& shape, const Box3& bounds, double spacing);
    Shape shape;
    Box3 bounds;
    FaceTree tree;
    std::vector<Face> faces;
    bool single() const { return faces.size() == 1; }
    /// Whether x, on face k with its normal there, lies on the solid's surface. `spacing` [m] sets what is near.
    bool on_surface(const Vec3& x, const Vec3& normal, int k, Real spacing) const;
};

/// Points of one face: on the solid's surface (beyond = 0), or on the face past its edges.
struct FacePoints {
    std::vector<Vec3> position, normal;
    std::vector<Real> beyond;  // distance to the nearest point on the solid's surface [m]
};

/// Points of all faces, each of which stands for the same area.
struct SolidPoints {
    std::vector<FacePoints> faces;
    double area = 0;  // of a point [m^2]
};

/// Points about six to a square of `spacing` [m], to `reach` [m] past the edges. Cells of half the spacing around the
/// surface hold random points; those within a thin layer about the face are brought onto it, which makes them even by
/// area (the layer's volume is its thickness times the area). A face that is made of a surface gives its own points.
/// Those of a solid's only face are brought near it alone (see below): most of them nobody will want.
SolidPoints points_on_faces(const FacedSolid& solid, double spacing, double reach, std::uint64_t seed);

/// x brought onto the face (by Newton steps of its distance, where it is not made of a surface), with the unit normal
/// there; false where that fails. `spacing` [m] is the size of what matters.
bool project_onto(const Face& face, Real spacing, Vec3& x, Vec3& normal);

/// Scanned meshes have slivers folded over others, whose normals point inwards or along the surface: there the distance
/// tells the way out.
void turn_outwards(const Face& face, Real spacing, const Vec3& x, Vec3& normal);

/// One step of the same, at a third of the cost: x comes as near as the face is flat over the way, and the normal is
/// that at the start. False, and x as it was, where the face is `most` [m] or more away. `slope`: of the distance at
/// the start [1].
bool bring_near(const Face& face, Real spacing, Real most, Vec3& x, Vec3& normal, Real* slope = nullptr);

}  // namespace thixo
