// Cuts a polygon in space into triangles.
#pragma once

#include <span>

#include "pipeline/geometry/mesh.h"

namespace thixo {

/// Appends the triangles of a simple polygon, convex or not, by cutting ears in the plane of its Newell normal. A
/// polygon that crosses itself may run out of ears; the rest becomes a fan. Repeated neighbours are dropped. Fewer than
/// three corners give no triangle. Requires indices in range.
void add_polygon(TriangleMesh& mesh, std::span<const Index> corners);

/// The same, with the texture coordinates of the corners. A vertex that occurs twice gets those of its first corner.
void add_polygon(TriangleMesh& mesh, std::span<const Index> corners, std::span<const Vec2f> uvs);

/// Faces as they are read, to be cut when all places are known.
class PolygonList {
  public:
    /// `uvs` are those of the corners, or too few where the face has none.
    void add(std::span<const Index> corners, std::span<const Vec2f> uvs);
    std::size_t size() const { return ends_.size(); }
    /// Appends the triangles of all faces. Texture coordinates are used where every face has them, and `mesh` had no
    /// triangles before.
    void cut_into(TriangleMesh& mesh) const;

  private:
    std::vector<Index> corners_;
    std::vector<Vec2f> uvs_;
    std::vector<std::size_t> ends_;  // of each face, in corners_
};

}  // namespace thixo
