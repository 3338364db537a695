// Triangle meshes and point sets as they come from files.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pipeline/base/math.h"

namespace thixo {

/// Indexed triangles; normals (unit, per vertex) and colours (linear, per vertex) may be empty.
struct TriangleMesh {
    std::vector<Vec3f> vertices;                  // [m] or file units
    std::vector<Vec3f> normals;                   // outward
    std::vector<Vec3f> colours;
    std::vector<std::array<Index, 3>> triangles;  // counter-clockwise seen from outside
};

}  // namespace thixo
