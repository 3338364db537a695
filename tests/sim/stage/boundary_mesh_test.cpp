// What is drawn of a plane: all of it, at any scale and place.
#include "sim/stage/boundary_mesh.h"

#include <gtest/gtest.h>

#include "pipeline/contract/scene_extent.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/geometry/face_tree.h"
#include "sim/space/scene_shapes.h"

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

/// A scene with a plane, and with its mirror image of a small ball, of a normal of this length. The plane and the mirror
/// are 0.3 m from the origin.
scene::Scene with_normals(double length, const Vec3d& away = Vec3d::Zero()) {
    const Vec3d n = length * Vec3d(0, 0.6, 0.8);
    const std::string normal = fmt::format("normal: [{}, {}, {}], offset: 0.3", n.x(), n.y(), n.z()),
                      there = fmt::format("translate: [{}, {}, {}]", away.x(), away.y(), away.z());
    return scene::parse_scene(
        fmt::format("world: {{boundaries: {{floor: {{shape: {{plane: {{{0}}}, {1}}}}}}}}}\nmaterials: {{m: {{}}}}\n"
                    "bodies: {{ball: {{material: m, shape: {{mirror: {{{0}, shapes: [{{sphere: {{radius: 0.1}}}}]}}, "
                    "{1}}}}}, half: {{material: m, shape: {{intersection: {{shapes: [{{sphere: {{radius: 1}}}}, "
                    "{{plane: {{{0}}}}}]}}, {1}}}}}}}\nsolver: {{spacing: 0.02}}\n",
                    normal, there),
        "plane.yaml");
}

TEST(APlane, HasAnOffsetInMetresWhateverTheLengthOfItsNormal) {
    for (const double length : {1.0, 2.0, 1e-3, 1e6})
        for (const Vec3d& away : {Vec3d(0, 0, 0), Vec3d(2e5, -1e5, 3e4)}) {
            const scene::Scene scene = near_origin(with_normals(length, away));
            const Vec3d here = away - scene.origin, n(0, 0.6, 0.8);
            const scene::Boundary& floor = scene.world.boundaries[0];
            const std::string what = fmt::format("{}, {} m away", length, away.norm());
            const auto at = [&](double height) -> Vec3 { return (here + height * n).cast<Real>(); };
            EXPECT_NEAR(make_shape(scene, floor.shape).distance(at(0.5)), 0.2, 1e-5) << what;
            EXPECT_NEAR(make_shape(scene, scene.bodies[0].shape).distance(at(0.6)), -0.1, 1e-5) << what;
            EXPECT_NEAR(hit(*boundary_mesh(scene, floor), here + 2 * n, -n), 1.7, 1e-4) << what;
            // The tree that trims surfels, and its faces grown by a tenth.
            const Shape half = make_shape(scene, scene.bodies[1].shape);
            EXPECT_NEAR(tree_distance(faces_of(half, 0), at(0.5)), 0.2, 1e-5) << what;
            EXPECT_NEAR(tree_distance(faces_of(half, Real(0.1)), at(0.5)), 0.1, 1e-5) << what;
        }
}

TEST(APlane, IsSeenByTheDefaultCameraWhereItIs) {
    const auto box = [](double length) { return scene::extent_of(with_normals(length)); };
    for (const double length : {2.0, 1e-3})
        for (const auto corner : {&scene::Extent::lower, &scene::Extent::upper})
            EXPECT_LT(((*box(length)).*corner - (*box(1)).*corner).norm(), 1e-9) << length;
}

}  // namespace
}  // namespace thixo
