// Triangle meshes and point sets as they come from files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pipeline/base/math.h"

namespace thixo {

/// Indexed triangles; normals (unit, per vertex), colours (linear, per vertex) and uvs (per corner) may be empty.
struct TriangleMesh {
    std::vector<Vec3f> vertices;  // [m] or file units
    std::vector<Vec3f> normals;   // outward
    std::vector<Vec3f> colours;
    std::vector<std::array<Index, 3>> triangles;  // counter-clockwise seen from outside
    std::vector<std::array<Vec2f, 3>> uvs;        // texture coordinates of each triangle's corners
};

}  // namespace thixo
