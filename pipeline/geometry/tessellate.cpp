#include "pipeline/geometry/tessellate.h"

#include "pipeline/geometry/shape_checks.h"

namespace thixo {

TriangleMesh tessellate(const Shape& shape, double cell, int segments) {
    positive_size(cell, "tessellation cell");
    if (segments < 3) throw InputError("tessellation segments are {}; use 3 or more", segments);
    if (auto mesh = shape.node().exact_mesh(segments)) return std::move(*mesh);
    return extract_surface(shape, cell);
}

TriangleMesh tessellate_plane(const Vec3d& centre, const Vec3d& normal, double extent, int rings) {
    positive_size(extent, "plane extent");
    finite_vector(centre, "plane centre");
    if (!(finite_vector(normal, "plane normal").norm() > 0))
        throw InputError("plane normal is zero; give the direction out of the solid");
    const Vec3d n = normal.normalized();
    Vec3d a, b;
    orthonormal_basis(n, a, b);
    TriangleMesh mesh;
    for (int ring = 0; ring <= rings; ++ring, extent *= 4)
        for (const auto& [s, t] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
            mesh.vertices.push_back((centre + extent / 2 * (s * a + t * b)).cast<float>());
    mesh.normals.assign(mesh.vertices.size(), n.cast<float>());
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    for (std::uint32_t inner = 0; inner + 4 < mesh.vertices.size(); inner += 4)
        for (std::uint32_t k = 0; k < 4; ++k) {
            const std::uint32_t next = (k + 1) % 4, outer = inner + 4;
            mesh.triangles.push_back({outer + k, outer + next, inner + next});
            mesh.triangles.push_back({outer + k, inner + next, inner + k});
        }
    return mesh;
}

}  // namespace thixo
