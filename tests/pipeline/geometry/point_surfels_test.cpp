#include "pipeline/geometry/point_surfels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/surface_sampling.h"
#include "pipeline/geometry/tessellate.h"
#include "pipeline/geometry/volume_sampling.h"

namespace thixo {
namespace {

/// Points of a sphere of radius 0.5, even (Fibonacci), red above and blue below.
TriangleMesh ball_of_points(std::size_t n) {
    TriangleMesh points;
    for (std::size_t i = 0; i < n; ++i) {
        const double z = 1 - (2.0 * double(i) + 1) / double(n), phi = double(i) * kPi * (3 - std::sqrt(5.0));
        const double r = std::sqrt(1 - z * z);
        const Vec3f normal = Vec3d(r * std::cos(phi), r * std::sin(phi), z).cast<float>();
        points.vertices.push_back(0.5f * normal);
        points.normals.push_back(normal);
        points.colours.push_back(z > 0 ? Vec3f(1, 0, 0) : Vec3f(0, 0, 1));
    }
    return points;
}

TEST(PointSurfels, HaveTheRadiusOfTheirSpacing) {
    const PointSurfels s = surfels_of_points(ball_of_points(4000));
    const double spacing = std::sqrt(kPi / 4000);
    EXPECT_NEAR(s.area / kPi, 1, 0.05);  // by twelve neighbours
    for (std::size_t i = 0; i < s.surfels.size(); ++i)
        EXPECT_NEAR(double(s.surfels.axis1[i].norm()) / spacing, 1.1, 0.12);
}

TEST(PointShape, IsTheBallItsPointsLieOn) {
    const Shape ball = point_shape(ball_of_points(4000));
    for (int k = 0; k < 4000; ++k) {
        const auto u = [&](int axis) { return 2 * random_unit(3, k, 0, axis) - 1; };
        const Vec3 x = Vec3d(u(0), u(1), u(2)).cast<Real>();
        // The planes of points 0.028 apart lie 0.0008 off the sphere where discs end.
        ASSERT_NEAR(ball.distance(x), x.norm() - Real(0.5), 2e-3);
    }
    EXPECT_NEAR(sample_volume(ball, {.spacing = 0.05}).total / (kPi / 6), 1, 0.01);
}

TEST(PointShape, OfInwardNormalsIsTurnedRound) {
    TriangleMesh inward = ball_of_points(2000);
    const Shape good = point_shape(inward);
    for (Vec3f& n : inward.normals) n = -n;
    for (Vec3f& v : inward.vertices) v += Vec3f(40, 0, 0);  // away from the origin it is the same
    PointSurfels surfels = surfels_of_points(inward);
    EXPECT_TRUE(orient_outward(surfels));
    EXPECT_FALSE(orient_outward(surfels));
    const Shape turned = point_shape(inward);
    for (const double r : {0.0, 0.2, 0.45, 0.55, 1.0})
        EXPECT_NEAR(turned.distance(Vec3(Real(40 + r), 0, 0)), good.distance(Vec3(Real(r), 0, 0)), 2e-3);
}

TEST(PointShape, ThatIsOpenKeepsTheSideItsNormalsSay) {
    // A bowl, seen from above: half a ball whose normals point to its middle.
    TriangleMesh bowl, all = ball_of_points(4000);
    for (std::size_t i = 0; i < all.vertices.size(); ++i)
        if (all.vertices[i].z() < 0) {
            bowl.vertices.push_back(all.vertices[i]);
            bowl.normals.push_back(-all.normals[i]);
        }
    PointSurfels surfels = surfels_of_points(bowl);
    EXPECT_FALSE(orient_outward(surfels));
}

TEST(PointShape, GivesASurfelForEveryPoint) {
    const TriangleMesh points = ball_of_points(2000);
    const Shape placed = transformed(point_shape(points), 2, rotation_from_degrees({0, 90, 0}), {1, 0, 0});
    const SampledSurface s = sample_surface(placed, {});
    ASSERT_EQ(s.surfels.size(), 2000u);
    EXPECT_EQ(s.sheets, 1);
    for (std::size_t i = 0; i < 2000; ++i) {
        const Vec3 expected = rotation_from_degrees({0, 90, 0}).toRotationMatrix().cast<Real>() *
                                  (Real(2) * points.vertices[i].cast<Real>()) +
                              Vec3(1, 0, 0);
        EXPECT_LT((s.surfels.position[i] - expected).norm(), 1e-5);
        EXPECT_EQ(s.colour[i], points.colours[i]);
    }
    EXPECT_NEAR(s.spacing / std::sqrt(4 * kPi / 2000), 1, 0.1);
    // A count resamples the same surface.
    const SampledSurface more = sample_surface(placed, {.count = 1000});
    ASSERT_EQ(more.surfels.size(), 1000u);
    for (std::size_t i = 0; i < 1000; ++i) {
        const Vec3 out = more.surfels.position[i] - Vec3(1, 0, 0);
        ASSERT_NEAR(out.norm(), 1, 0.005);
        ASSERT_GT(out.normalized().dot(more.surfels.normal[i]), 0.98);
        if (std::abs(out.x()) > Real(0.2)) {
            ASSERT_EQ(more.colour[i].x() > 0.5f, out.x() > 0);  // z has become x
        }
    }
}

TEST(MeshSurfels, LieOnTheMeshAtTheCountAskedForWithItsColours) {
    TriangleMesh mesh = tessellate(torus(0.5, 0.2), 0.05, 48);
    for (const Vec3f& v : mesh.vertices) mesh.colours.push_back(Vec3f(v.x() + 0.7f, 0.5f, 0));
    const Shape shape = mesh_shape(mesh);
    const SampledSurface s = sample_surface(shape, {.count = 3000});
    ASSERT_EQ(s.surfels.size(), 3000u);
    EXPECT_EQ(s.sheets, 1);
    ASSERT_EQ(s.colour.size(), 3000u);
    EXPECT_NEAR(s.area / (4 * kPi * kPi * 0.1), 1, 0.02);
    for (std::size_t i = 0; i < 3000; ++i) {
        const Vec3& x = s.surfels.position[i];
        ASSERT_LT(std::abs(shape.distance(x)), 1e-4);
        ASSERT_NEAR(s.colour[i].x(), x.x() + 0.7f, 2e-3f);
        // Normals are blended from the corners, which have the exact ones: 3.6 degrees is the most.
        const Vec3 ring = Vec3(x.x(), x.y(), 0).normalized() * Real(0.5);
        ASSERT_GT(s.surfels.normal[i].dot((x - ring).normalized()), 0.998);
    }
}

TEST(MeshSurfels, AMeshGivesASurfelForEveryVertex) {
    TriangleMesh mesh = tessellate(sphere(0.5), 0.05, 48);
    mesh.normals.clear();
    const std::size_t vertices = welded(mesh).vertices.size();
    const SampledSurface s = sample_surface(mesh_shape(mesh), {});
    ASSERT_EQ(s.surfels.size(), vertices);
    for (std::size_t i = 0; i < vertices; ++i)
        ASSERT_GT(s.surfels.normal[i].dot(s.surfels.position[i].normalized()), 0.999);
    EXPECT_THROW(sample_surface(sphere(1), {}), InputError);
}

TEST(PointSurfels, RefuseWhatIsNoSurface) {
    TriangleMesh points = ball_of_points(100);
    points.normals.clear();
    EXPECT_THROW(surfels_of_points(points), InputError);
    points = ball_of_points(100);
    points.normals[7].setZero();
    EXPECT_THROW(surfels_of_points(points), InputError);
    EXPECT_THROW(surfels_of_points(ball_of_points(5)), InputError);
    points = ball_of_points(100);
    for (int k = 0; k < 20; ++k) points.vertices[std::size_t(k)] = points.vertices[0];
    EXPECT_THROW(surfels_of_points(points), InputError);
    // Lengths beyond the range of single precision, in places and in normals.
    points = ball_of_points(100);
    points.vertices[7].x() = 1e30f;
    EXPECT_THROW(surfels_of_points(points), InputError);
    points = ball_of_points(100);
    points.normals[7] *= 1e30f;
    EXPECT_THROW(surfels_of_points(points), InputError);
}

}  // namespace
}  // namespace thixo
