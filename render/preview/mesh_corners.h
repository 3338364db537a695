// A triangle mesh as the preview draws it: corners with smooth or creased normals, and the edges worth a line.
#pragma once

#include <array>
#include <vector>

#include "pipeline/geometry/mesh.h"

namespace thixo::preview {

struct MeshCorners {
    std::vector<std::array<float, 4>> positions;  // three a triangle; the fourth number is 1
    std::vector<std::array<float, 4>> normals;    // unit, of the same corners; the fourth number is 0
    std::vector<std::array<float, 4>> lines;      // two ends an edge
};

/// The normal of a corner is the area-weighted mean of faces around its vertex: those that lie within 40 degrees of the
/// corner's own face. Edges where two faces meet at more, or that end a sheet, become lines. Normals stored in the mesh
/// are not used: they need not tell creases.
MeshCorners mesh_corners(const TriangleMesh& mesh);

}  // namespace thixo::preview
