// What is drawn of a plane: all of it, at any scale and place.
#include "sim/stage/boundary_mesh.h"

#include <gtest/gtest.h>

#include "pipeline/contract/scene_io.h"

namespace thixo {
namespace {

/// A ball of 10 spacings on a plane below it, `away` [m] along x.
TriangleMesh floor_below(double spacing, double away, const std::string& normal = "[0, 0, 1]") {
    const scene::Scene scene = scene::parse_scene(
        fmt::format("world: {{boundaries: {{floor: {{shape: {{plane: {{normal: {}}}}}}}}}}}\nmaterials: {{m: {{}}}}\n"
                    "bodies: {{ball: {{material: m, shape: {{sphere: {{radius: {}}}, translate: [{}, 0, {}]}}}}}}\n"
                    "solver: {{spacing: {}}}\n",
                    normal, 10 * spacing, away, 20 * spacing, spacing),
        "plane.yaml");
    return *boundary_mesh(scene, scene.world.boundaries[0]);
}

/// Where a ray meets the mesh [m along it]; infinity where it does not. In the mesh's single-precision vertices.
double hit(const TriangleMesh& mesh, const Vec3d& from, const Vec3d& direction, double* widest = nullptr) {
    for (const auto& t : mesh.triangles) {
        const Vec3d a = mesh.vertices[t[0]].cast<double>(), u = mesh.vertices[t[1]].cast<double>() - a,
                    v = mesh.vertices[t[2]].cast<double>() - a;
        const Vec3d n = u.cross(v);
        const double along = n.dot(a - from) / n.dot(direction);
        const Vec3d at = from + along * direction - a;
        const double p = n.dot(at.cross(v)) / n.squaredNorm(), q = n.dot(u.cross(at)) / n.squaredNorm();
        if (!(along > 0) || p < -1e-9 || q < -1e-9 || p + q > 1 + 1e-9) continue;
        if (widest) *widest = std::max(u.norm(), v.norm());
        return along;
    }
    return INFINITY;
}

TEST(APlane, IsDrawnToTheHorizonAtAnyScale) {
    // The eye is 100 spacings above the plane. A ray a thousandth below the horizon meets it 1e5 spacings away.
    for (const double spacing : {1e-6, 1e-4, 0.01, 6.0, 1e4, 1e6}) {
        const TriangleMesh mesh = floor_below(spacing, 0);
        for (int k = 0; k < 16; ++k) {
            const double turn = k * kPi / 8 + 0.1;
            const Vec3d direction(std::cos(turn), std::sin(turn), -1e-3);
            EXPECT_NEAR(hit(mesh, {0, 0, 100 * spacing}, direction), 1e5 * spacing, spacing) << spacing << ", " << k;
        }
    }
}

TEST(APlane, IsDrawnBelowMatterFarFromTheOrigin) {
    for (const double away : {1e3, -1e5, 1e6}) {
        double widest = 0;
        const TriangleMesh mesh = floor_below(0.1, away);
        EXPECT_NEAR(hit(mesh, {away, 0.01, 1}, {0.001, 0.002, -1}, &widest), 1, 1e-6) << away;
        EXPECT_LE(widest, 400) << away;  // the square in the middle, whose triangles are met most exactly
        EXPECT_LT(hit(mesh, {away, 0, 1}, {1, 0, -1e-4}), INFINITY) << away;
    }
}

TEST(APlane, OfAnyDirectionIsEndless) {
    for (const char* normal : {"[1, 0, 0]", "[0, -1, 2]", "[1, 1, 1]"})
        for (const double spacing : {1e-6, 0.01, 1e3}) {
            const TriangleMesh mesh = floor_below(spacing, 0, normal);
            const Vec3d n = mesh.normals[0].cast<double>();
            Vec3d a, b;
            orthonormal_basis(n, a, b);
            for (const Vec3d& along : {a, b, Vec3d(-a), Vec3d(-b), Vec3d(a - b)})
                EXPECT_LT(hit(mesh, 50 * spacing * n, along - 1e-3 * n), INFINITY) << normal << ", " << spacing;
        }
}

}  // namespace
}  // namespace thixo
