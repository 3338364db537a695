#include "pipeline/geometry/tessellate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/sampled_shape.h"
#include "pipeline/geometry/shapes.h"

namespace thixo {
namespace {

const std::vector<Vec2d> kGlass = {{0, 0},          {0.045, 0},     {0.050, 0.120}, {0.0475, 0.1225}, {0.045, 0.120},
                                   {0.0405, 0.016}, {0.038, 0.011}, {0.034, 0.009}, {0, 0.008}};

struct Named {
    const char* name;
    Shape shape;
};

std::vector<Named> shapes() {
    const Shape a = box({1, 0.8, 0.6}), b = translated(sphere(0.5), {0.4, 0.2, 0.2});
    return {{"sphere", sphere(0.7)},
            {"ellipsoid", ellipsoid({0.9, 0.5, 0.3})},
            {"box", a},
            {"rounded box", box({1.2, 0.8, 0.5}, 0.1)},
            {"bar of no core", box({0.4, 0.4, 1}, 0.2)},
            {"cylinder", cylinder(0.5, 1.1)},
            {"rounded cylinder", cylinder(0.5, 1.1, 0.15)},
            {"pill", cylinder(0.5, 1, 0.5)},
            {"rounded cone", rounded_cone(0.5, 0.2, 0.8)},
            {"capsule", capsule({-0.3, 0.1, -0.2}, {0.4, 0.2, 0.5}, 0.3)},
            {"torus", torus(0.6, 0.25)},
            {"glass", scaled(revolve(kGlass), 8)},
            {"cone with a tip", revolve({{0, 0}, {0.5, 0}, {0, 0.7}})},
            {"union", union_of({a, b})},
            {"smooth difference", difference_of({a, b}, 0.15)},
            {"touching corners", union_of({translated(box({0.5, 0.5, 0.5}), {0.25, 0.25, 0.25}),
                                           translated(box({0.5, 0.5, 0.5}), {-0.25, -0.25, 0.25})})},
            {"shell", shell(sphere(0.5), 0.1)}};
}

double area_of(const TriangleMesh& mesh) {
    double sum = 0;
    for (const auto& t : mesh.triangles)
        sum += (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                   .cast<double>()
                   .cross((mesh.vertices[t[2]] - mesh.vertices[t[0]]).cast<double>())
                   .norm() /
               2;
    return sum;
}

void expect_closed(const TriangleMesh& mesh, const std::string& name) {
    const MeshReport r = inspect_mesh(mesh);
    EXPECT_EQ(r.open_edges, 0u) << name;
    EXPECT_EQ(r.bad_edges, 0u) << name;
    EXPECT_GT(r.volume, 0) << name;
}

TEST(Tessellation, IsClosedAndTurnedOutwards) {
    for (const Named& s : shapes()) expect_closed(tessellate(s.shape, 0.04, 40), s.name);
}

TEST(Extraction, IsClosedAndTurnedOutwards) {
    for (const Named& s : shapes()) expect_closed(extract_surface(s.shape, 0.041), s.name);
}

TEST(Extraction, IsClosedAtEveryGridOfARoughShape) {
    // Two blobs joined by a neck thinner than a cell, at many grids: faces and cells with more than one sheet occur.
    const Shape blobs = union_of({translated(sphere(0.3), {-0.31, 0.02, 0}), translated(sphere(0.3), {0.31, 0, 0.03}),
                                  translated(sphere(0.3), {0, 0.52, 0.01})},
                                 0.05);
    for (double cell = 0.05; cell < 0.2; cell *= 1.07) expect_closed(extract_surface(blobs, cell), "blobs");
}

/// Shapes whose edges a grid does not meet, and the bowl of an obstacle: two balls cut by a plane.
std::vector<Named> edged_shapes() {
    const Quatd turn = rotation_from_degrees({17, 33, 71});
    const Shape bowl = difference_of({sphere(0.5), sphere(0.4), translated(box({2, 2, 1}), {0, 0, 0.5})});
    return {{"box", rotated(box({1, 0.8, 0.6}), turn)},
            {"cylinder", rotated(cylinder(0.5, 1.1), turn)},
            {"union", rotated(union_of({box({1, 0.8, 0.6}), translated(sphere(0.3), {0, 0, 0.3})}), turn)},
            {"bowl", bowl},
            {"turned bowl", rotated(bowl, turn)}};
}

TEST(Extraction, KeepsEdgesSharp) {
    // A chord of sqrt(3) cells of the smallest circle, 0.3 m, is off by 3 cells^2/(8 R): 3.1e-3 m. Rounded edges would
    // be off by 0.3 cells: 1.5e-2 m. A triangle's shading normals are those of its own face, up to the turn of a chord.
    const double cell = 0.05, off = 3 * square(cell) / (8 * 0.3);
    for (const Named& s : edged_shapes()) {
        const TriangleMesh mesh = extract_surface(s.shape, cell);
        expect_closed(mesh, s.name);
        for (const auto& t : mesh.triangles) {
            const Vec3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
            for (const Vec3f& x : {Vec3f((a + b) / 2), Vec3f((b + c) / 2), Vec3f((c + a) / 2)})
                EXPECT_LT(std::abs(s.shape.distance(x.cast<Real>())), off) << s.name << " at " << x.transpose();
            const Vec3f n = (b - a).cross(c - a);
            if (n.norm() < 0.1f * float(square(cell))) continue;  // narrow ones are tilted by the chord
            for (const Index v : t) EXPECT_GT(n.normalized().dot(mesh.normals[v]), 0.85f) << s.name << ": " << a.transpose() << ", " << b.transpose() << ", " << c.transpose();
        }
    }
}

TEST(Tessellation, LiesOnTheSurfaceWithItsNormals) {
    // Vertices are exact to float rounding, extracted ones at edges to a tenth of a cell (4e-3). Where edges are nearer
    // to each other than a cell, a triangle may span one. A corner may then have the normal of the far face. That is
    // 120 degrees off at the sharpest edge here.
    for (const Named& s : shapes()) {
        const TriangleMesh mesh = tessellate(s.shape, 0.04, 96);
        ASSERT_EQ(mesh.normals.size(), mesh.vertices.size());
        for (const Vec3f& v : mesh.vertices) ASSERT_LT(std::abs(s.shape.distance(v.cast<Real>())), 4e-3) << s.name << " at " << v.transpose();
        for (const Vec3f& n : mesh.normals) ASSERT_NEAR(n.norm(), 1, 1e-5) << s.name;
        for (const auto& t : mesh.triangles)
            for (const Index v : t) {
                const Vec3f n =
                    (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
                if (n.norm() > 1e-6f) {
                    ASSERT_GT(n.normalized().dot(mesh.normals[v]), -0.5f) << s.name;
                }
            }
    }
}

TEST(Tessellation, HasTheVolumeOfTheShape) {
    // Inscribed polygons of n sides lose (2 pi^2/3)/n^2 of the area of a circle, twice that for spheres: 2e-3 at n
    // = 96.
    EXPECT_NEAR(inspect_mesh(tessellate(sphere(0.5), 1, 96)).volume / (kPi / 6), 1, 2e-3);
    EXPECT_NEAR(inspect_mesh(tessellate(cylinder(0.5, 2), 1, 96)).volume / (kPi / 2), 1, 1e-3);
    EXPECT_NEAR(inspect_mesh(tessellate(box({1, 2, 3}), 1)).volume, 6, 1e-6);
    EXPECT_NEAR(area_of(tessellate(box({1, 2, 3}), 1)), 22, 1e-5);
    // Extracted: linear between points on the surface, second order in the cell.
    EXPECT_NEAR(inspect_mesh(extract_surface(sphere(0.5), 0.02)).volume / (kPi / 6), 1, 2e-3);
    EXPECT_NEAR(area_of(extract_surface(sphere(0.5), 0.02)) / kPi, 1, 2e-3);
}

TEST(Tessellation, KeepsFlatWallsFlatAndRoundOnesSmooth) {
    // The long wall of the glass is a cone: its normals are constant along a generator, although roundings touch both
    // ends.
    const TriangleMesh mesh = tessellate(revolve(kGlass), 0.01, 128);
    const Vec2d wall = Vec2d(0.120, -0.005).normalized();  // (r, z) normal of the outer wall
    int checked = 0;
    for (const auto& t : mesh.triangles) {
        int on_wall = 0;
        for (const Index v : t) {
            const Vec3f& p = mesh.vertices[v];
            const double r = std::hypot(p.x(), p.y());
            on_wall += std::abs((r - 0.045) - p.z() / 24) < 1e-6;
        }
        if (on_wall < 3) continue;
        ++checked;
        for (const Index v : t) {
            const Vec3f p = mesh.vertices[v], n = mesh.normals[v];
            const double r = std::hypot(p.x(), p.y());
            EXPECT_NEAR(n.dot(Vec3f(float(wall.x() * p.x() / r), float(wall.x() * p.y() / r), float(wall.y()))), 1,
                        1e-5);
        }
    }
    EXPECT_EQ(checked, 256);  // two triangles a segment
}

TEST(Tessellation, OfARoomIsTurnedInwards) {
    EXPECT_NEAR(inspect_mesh(tessellate(inverted(box({1, 2, 3})), 1)).volume, -6, 1e-6);
}

TEST(Tessellation, OfASampledShapeIsThatOfTheShape) {
    const Shape glass = revolve(kGlass);
    EXPECT_EQ(tessellate(sampled(glass, 0.005, 0.01), 0.01).vertices, tessellate(glass, 0.01).vertices);
}

TEST(Tessellation, OfAPlaneFacesItsNormal) {
    const TriangleMesh mesh = tessellate_plane({1, 2, 3}, {1, 1, 2}, 4);
    EXPECT_NEAR(area_of(mesh), 16, 1e-5);
    for (const auto& t : mesh.triangles) {
        const Vec3f n =
            (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).normalized();
        EXPECT_NEAR(n.dot(Vec3f(1, 1, 2).normalized()), 1, 1e-6);
    }
}

TEST(Tessellation, RingsOfAPlaneCoverItOnceWithoutGaps) {
    const TriangleMesh mesh = tessellate_plane({1, 2, 3}, {1, 1, 2}, 4, 3);
    EXPECT_NEAR(area_of(mesh), square(4 * 64), 1e-5 * square(4 * 64));  // an overlap or a gap would change it
    for (const auto& t : mesh.triangles) {
        const Vec3f n =
            (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).normalized();
        EXPECT_NEAR(n.dot(Vec3f(1, 1, 2).normalized()), 1, 1e-5);
    }
}

/// A ball of radius 1 that takes itself for smaller, as rounding makes of shapes far away.
struct BallBeyondItsBounds final : Shape::Node {
    Real distance(const Vec3& x) const override { return x.norm() - 1; }
    std::optional<Box3> bounds() const override { return Box3{Vec3(-0.5f, -1, -1), Vec3(1, 0.5f, 1)}; }
};

TEST(Tessellation, OfAShapeThatReachesBeyondItsBoundsIsClosedThere) {
    const TriangleMesh mesh = extract_surface(Shape(std::make_shared<BallBeyondItsBounds>()), 0.1);
    EXPECT_TRUE(inspect_mesh(mesh).closed);
    for (const Vec3f& v : mesh.vertices) EXPECT_LE(v.norm(), 1.2f);
}

TEST(Tessellation, RefusesWhatHasNoClosedSurface) {
    EXPECT_THROW(tessellate(plane({0, 0, 1}, 0), 0.1), InputError);
    EXPECT_THROW(tessellate(intersection_of({sphere(1), translated(sphere(1), {3, 0, 0})}), 0.1), InputError);
    EXPECT_THROW(extract_surface(sphere(1), 1e-5), InputError);
    EXPECT_THROW(tessellate(sphere(1), 0), InputError);
}

}  // namespace
}  // namespace thixo
