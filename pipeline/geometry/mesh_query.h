// Closest point and winding number of a triangle mesh by one bounding-volume hierarchy.
#pragma once

#include <memory>

#include "pipeline/base/math.h"
#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

struct TriangleTree;  // mesh_tree.h

/// Closest point of the triangle a b c to p, by the region of its barycentric plane (Ericson 2005, 5.1.5).
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Immutable query structure over a mesh, which need be neither closed nor free of self-intersections. Queries are
/// thread-safe.
class MeshQuery {
  public:
    /// Builds the tree. Triangles without area are left out. Throws InputError where no triangle remains, an index is
    /// out of range or a vertex is not finite.
    explicit MeshQuery(TriangleMesh mesh);
    ~MeshQuery();
    MeshQuery(MeshQuery&&) noexcept;
    MeshQuery& operator=(MeshQuery&&) noexcept;

    /// Of a place that is not finite, or too far to be squared: the first triangle at the largest distance there is.
    struct Closest {
        Real distance;  // [m], unsigned
        Vec3 point;
        Index triangle;  // of mesh().triangles; the lowest index where several are equally near
    };
    /// The same result, found faster where the triangle `near` (of mesh().triangles, with an area) is not far from the
    /// closest one.
    Closest closest(const Vec3& x, Index near = kNone) const;

    /// Generalised winding number (Jacobson et al. 2013):
    ///     w(x) = sum of signed solid angles / (4 pi)
    /// It is 1 inside and 0 outside a closed mesh, and smooth across holes. Clusters farther away than accuracy *
    /// cluster radius are approximated by their dipole (Barill et al. 2018).
    Real winding_number(const Vec3& x, Real accuracy = Real(2.3)) const;
    /// Whether winding_number(x) > 1/2.
    bool inside(const Vec3& x) const;
    /// Closest distance, negative inside.
    Real signed_distance(const Vec3& x) const;

    const TriangleMesh& mesh() const { return mesh_; }
    Box3 bounds() const;

  private:
    TriangleMesh mesh_;
    std::unique_ptr<const TriangleTree> tree_;
};

}  // namespace thixo
