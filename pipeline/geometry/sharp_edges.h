// Sharp edges of a surface that is extracted from a grid. Source: Kobbelt et al. 2001 (extended marching cubes).
#pragma once

#include <optional>
#include <vector>

#include "pipeline/geometry/face_tree.h"
#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

/// Triangles around a centre. The loop's vertices stand on the grid's edges, counter-clockwise seen from outside.
struct Fan {
    Index centre;
    std::vector<Index> loop;
    bool on_edge;  // the centre is a point of an edge or corner
};

/// The smooth faces of a shape. At an edge each has a normal of its own, and none is a mean of two.
class SmoothFaces {
  public:
    /// Differences are a twentieth of `cell` [m] wide to either side.
    SmoothFaces(const Shape& shape, double cell);
    /// Number of the nearest face that bounds the solid at x, a point of its surface.
    std::size_t nearest(const Vec3f& x) const;
    /// Outward unit normal of a face; the zero vector where its distance has no gradient.
    Vec3f normal(std::size_t face, const Vec3f& x) const;
    double distance(std::size_t face, const Vec3f& x) const { return double(faces_[face].distance(x.cast<Real>())); }

  private:
    FaceTree tree_;
    std::vector<Shape> faces_;
    Real step_;
};

/// Whether normals at the loop's vertices are more than 40 degrees apart.
bool crosses_edge(const TriangleMesh& mesh, const std::vector<Index>& loop);

/// The point nearest to the fan's centre where the faces at the loop's vertices meet, by least squares. It begins where
/// their tangent planes meet. Empty where it is more than a cell's diagonal away, or a triangle of the fan would fold.
std::optional<Vec3f> point_on_edge(const SmoothFaces& faces, const TriangleMesh& mesh, const Fan& fan, double cell);

/// Joins the centres of neighbouring fans along their edge, in place of the grid's segment across it. Centres on edges
/// get a copy for each side, with that side's normal.
void keep_edges_sharp(TriangleMesh& mesh, const std::vector<Fan>& fans);

}  // namespace thixo
