// Random points on the faces of a solid, even by area: what sampling chooses from.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/geometry/face_tree.h"

namespace thixo {

/// A solid taken apart: the shape, its faces, and the tree over their numbers, without differences.
struct FacedSolid {
    explicit FacedSolid(const Shape& shape);
    Shape shape;
    Box3 bounds;
    FaceTree tree;
    std::vector<Shape> faces;
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

/// Points about eight to a square of `spacing` [m], to `reach` [m] past the edges. Cells of half the spacing around the
/// surface hold random points; those within a thin layer about the face are brought onto it, which makes them even by
/// area (the layer's volume is its thickness times the area).
SolidPoints points_on_faces(const FacedSolid& solid, double spacing, double reach, std::uint64_t seed);

/// x brought onto the zero set of the distance by Newton steps, with the unit normal there; false where that fails.
/// `spacing` [m] is the size of what matters.
bool project_onto(const Shape& face, Real spacing, Vec3& x, Vec3& normal);

}  // namespace thixo
