// Random points on the faces of a solid, even by area. Sampling chooses surfels from them.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/geometry/direct_surface.h"
#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {

/// A face: its distance, and the surface that it is made of, if any.
struct Face {
    SlopedShape shape;
    std::shared_ptr<const DirectSurface> surface;
    Real distance(const Vec3& x) const { return shape.distance(x); }
    Vec3 gradient(const Vec3& x, Real step) const { return shape.gradient(x, step); }
};

/// Whether a point of a face lies on the surface of the solid. thin: the matter there is too thin to tell.
enum class OnSurface { no, thin, yes };

/// A solid and its parts: the shape, its faces, and the tree over their numbers, without differences. Faces of many
/// parts are prepared for many evaluations (by_blocks), for surfels `spacing` [m] apart.
struct FacedSolid {
    FacedSolid(const Shape& shape, const Box3& bounds, double spacing);
    Shape shape;
    Box3 bounds;
    FaceTree tree;
    std::vector<Face> faces;
    bool single() const { return faces.size() == 1; }
    /// Whether x, a point of face k with the normal there, lies on the solid's surface. `spacing` [m] sets the
    /// tolerance: matter thinner than kThinnest of it is too thin to tell.
    OnSurface on_surface(const Vec3& x, const Vec3& normal, int k, Real spacing) const;
};

/// Points of one face: on the solid's surface (beyond = 0), or on the face beyond its edges.
struct FacePoints {
    std::vector<Vec3> position, normal;
    std::vector<Real> beyond;  // distance to the nearest point on the solid's surface [m]
    std::size_t thin = 0;      // points on matter that is too thin, which are left out
};

/// Points of all faces, each of which stands for the same area.
struct SolidPoints {
    std::vector<FacePoints> faces;
    double area = 0;  // of a point [m^2]
};

/// About six points per square of `spacing` [m], up to `reach` [m] beyond the edges. Cells of half the spacing around
/// the surface hold random points. Points within a thin layer around the face are brought onto it. They are then even
/// by area, because the layer's volume is its thickness times the area. A face that is made of a surface gives its own
/// points. Points of a solid's only face are just brought near it (see below), because most of them are not used.
SolidPoints points_on_faces(const FacedSolid& solid, double spacing, double reach, std::uint64_t seed);

/// Brings x onto the face and gives the unit normal there; false where that fails. A face that is not made of a surface
/// takes Newton steps of its distance. `spacing` [m] is the scale of their tolerances.
bool project_onto(const Face& face, Real spacing, Vec3& x, Vec3& normal);

/// Scanned meshes have slivers that are folded over others, with normals that point inwards or along the surface. There
/// the distance gives the direction outwards.
void turn_outwards(const Face& face, Real spacing, const Vec3& x, Vec3& normal);

/// One such step, at a third of the cost. It ends near the face as far as the face is flat there; the normal is that at
/// the start. False where the face is `most` [m] or more away: x is then unchanged. `slope` is the slope of the
/// distance at the start [1].
bool bring_near(const Face& face, Real spacing, Real most, Vec3& x, Vec3& normal, Real* slope = nullptr);

}  // namespace thixo
