// Closest point and winding number of a triangle mesh by one bounding-volume hierarchy.
#pragma once

#include <memory>

#include "pipeline/base/math.h"
#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

struct TriangleTree;  // mesh_tree.h

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

    struct Closest {
        Real distance;  // [m], unsigned
        Vec3 point;
        Index triangle;  // of mesh().triangles; the lowest index where several are equally near
    };
    /// Quicker where `near` is a triangle (of mesh().triangles, with an area) not far from the closest one; the result
    /// is the same.
    Closest closest(const Vec3& x, Index near = kNone) const;

    /// Generalised winding number (Jacobson et al. 2013), w(x) = sum of signed solid angles / (4 pi): 1 inside, 0
    /// outside a closed mesh, smooth across holes. Far clusters by their dipole (Barill et al. 2018): farther than
    /// accuracy * cluster radius.
    Real winding_number(const Vec3& x, Real accuracy = Real(2.3)) const;
    /// winding_number(x) > 1/2
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
