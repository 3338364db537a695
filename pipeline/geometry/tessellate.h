// Closed triangle meshes of shapes, for drawing.
#pragma once

#include "pipeline/geometry/mesh.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

/// The surface of a bounded shape as a closed mesh, outwards oriented, with unit vertex normals.
/// Shapes that know their own mesh (revolve, box, cylinder, sphere, capsule, cone, torus, mesh; moved, inverted) give
/// it, with `segments` around a turn and edges sharper than 40 degrees kept sharp by doubled vertices. Others are
/// extracted from the distance on a grid of edge `cell` [m] and brought onto the zero set; their edges come out rounded
/// by a cell. Throws InputError where the shape is unbounded, or empty at this cell, or the grid would have more than
/// 2^28 cells.
TriangleMesh tessellate(const Shape& shape, double cell, int segments = 128);

/// The extraction alone: every grid cell's crossing edges are joined into loops, each loop a fan about its projected
/// centre.
TriangleMesh extract_surface(const Shape& shape, double cell);

/// A square of edge `extent` [m] about `centre`, of two triangles.
TriangleMesh tessellate_plane(const Vec3d& centre, const Vec3d& normal, double extent);

}  // namespace thixo
