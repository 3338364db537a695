// Closed triangle meshes of shapes, for drawing.
#pragma once

#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

/// The surface of a bounded shape as a closed mesh, oriented outwards, with unit vertex normals.
///
/// Many shapes give their own mesh: revolve, box, cylinder, sphere, capsule, cone, torus, mesh, also moved or inverted.
/// It has `segments` to a full turn, and doubled vertices keep edges sharper than 40 degrees sharp. Other meshes are
/// extracted from the distance on a grid of the edge `cell` [m] and brought onto the zero set. Edges stay sharp, but
/// for those that are nearer to each other than a cell. Throws InputError where the shape is unbounded, or empty at this cell, or the grid would have more than
/// 2^28 cells.
TriangleMesh tessellate(const Shape& shape, double cell, int segments = 128);

/// The extraction alone. The crossing edges of every grid cell are joined into loops. Each loop becomes a fan around
/// its centre, which comes to the zero set or to an edge (sharp_edges.h).
TriangleMesh extract_surface(const Shape& shape, double cell);

/// A square of two triangles, with the edge `extent` [m], around `centre`. Each ring around it is four times as wide. So
/// a plane reaches far, and no triangle is much larger than its distance: rays meet it as exactly as what is near.
TriangleMesh tessellate_plane(const Vec3d& centre, const Vec3d& normal, double extent, int rings = 0);

}  // namespace thixo
