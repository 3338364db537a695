#include "pipeline/geometry/mesh_query.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/sampled_shape.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/tessellate.h"

namespace thixo {
namespace {

constexpr int kPoints = 100000;

/// A cow-like blob: body, legs, head and horns joined smoothly.
Shape blob() {
    std::vector<Shape> parts = {ellipsoid({0.6, 0.3, 0.3}), translated(ellipsoid({0.22, 0.16, 0.16}), {0.7, 0, 0.25})};
    for (const double x : {-0.35, 0.35})
        for (const double y : {-0.15, 0.15}) parts.push_back(capsule({x, y, 0}, {x, y, -0.6}, 0.08));
    for (const double y : {-0.1, 0.1}) parts.push_back(capsule({0.7, y, 0.35}, {0.72, 2 * y, 0.55}, 0.03));
    return union_of(parts, 0.06);
}

struct Case {
    const char* name;
    Shape truth;
    TriangleMesh mesh;
    double tolerance;  // how far the mesh may lie from the true surface
};

const std::vector<Case>& cases() {
    // Chords sag by r (1 - cos(pi/n)); the extracted blob by its curvature: cell^2/(8 * 0.03) at the horns.
    static const std::vector<Case> all = {{"sphere", sphere(0.8), tessellate(sphere(0.8), 0.02, 200), 2e-4},
                                          {"torus", torus(0.6, 0.25), tessellate(torus(0.6, 0.25), 0.02, 200), 2e-4},
                                          {"blob", blob(), extract_surface(blob(), 0.015), 2e-3}};
    return all;
}

Vec3 point(const Box3& box, std::uint64_t k) {
    const Vec3d u(random_unit(3, k, 0, 0), random_unit(3, k, 0, 1), random_unit(3, k, 0, 2));
    const Vec3d lower = box.lower.cast<double>(), upper = box.upper.cast<double>(), margin = 0.1 * (upper - lower);
    return (lower - margin + (upper - lower + 2 * margin).cwiseProduct(u)).cast<Real>();
}

/// Counts points where right(x) is false, of those that are farther from the true surface than the mesh may be.
int count_wrong(const Case& c, const Box3& box, const std::function<bool(const Vec3&, Real)>& right) {
    return static_cast<int>(parallel_sum(kPoints, [&](std::size_t k) {
        const Vec3 x = point(box, k);
        const Real d = c.truth.distance(x);
        return std::abs(d) > c.tolerance && !right(x, d) ? 1.0 : 0.0;
    }));
}

TEST(WindingNumber, TellsInsideFromOutsideOfClosedMeshes) {
    for (const Case& c : cases()) {
        const MeshQuery query(c.mesh);
        EXPECT_EQ(count_wrong(c, query.bounds(), [&](const Vec3& x, Real d) { return query.inside(x) == (d < 0); }), 0)
            << c.name;
    }
}

TEST(WindingNumber, TellsInsideFromOutsideOfMeshesWithHoles) {
    // One triangle in twenty is missing: right wherever the surface is farther than the size of a hole, three triangle
    // edges.
    for (const Case& c : cases()) {
        TriangleMesh mesh = c.mesh;
        mesh.triangles.clear();
        for (std::size_t k = 0; k < c.mesh.triangles.size(); ++k)
            if (random_unit(5, k, 0, 0) >= 0.05) mesh.triangles.push_back(c.mesh.triangles[k]);
        const MeshQuery query(mesh);
        const Real hole = 3 * Real(0.025);
        EXPECT_EQ(count_wrong(c, query.bounds(),
                              [&](const Vec3& x, Real d) { return std::abs(d) < hole || query.inside(x) == (d < 0); }),
                  0)
            << c.name;
    }
}

TEST(WindingNumber, ClosesOneLargeHole) {
    // A sphere without its cap above 60 degrees of latitude: the winding number still passes 1/2 within the missing
    // cap's height.
    TriangleMesh mesh = tessellate(sphere(1), 0.02, 100);
    std::erase_if(mesh.triangles, [&](const auto& t) { return mesh.vertices[t[0]].z() > 0.87f; });
    const MeshQuery query(mesh);
    EXPECT_TRUE(query.inside(Vec3(0, 0, 0)));
    EXPECT_TRUE(query.inside(Vec3(0, 0, Real(0.6))));
    EXPECT_FALSE(query.inside(Vec3(0, 0, Real(1.3))));
    EXPECT_FALSE(query.inside(Vec3(0, Real(1.1), 0)));
}

TEST(WindingNumber, OfTheHierarchyIsThatOfAllTriangles) {
    // The first term of the expansion at 2.3 radii: below 0.06 at random points, far from the 1/2 that decides.
    for (const Case& c : cases()) {
        const MeshQuery query(c.mesh);
        for (int k = 0; k < 300; ++k) {
            const Vec3 x = point(query.bounds(), k);
            EXPECT_NEAR(query.winding_number(x), query.winding_number(x, Real(1e9)), 0.1) << c.name;
        }
    }
}

TEST(WindingNumber, IsOneInsideAndZeroOutside) {
    // The solid angles of all triangles add up to 4 pi or 0. Float rounding of ten thousand stays below 1e-4.
    const MeshQuery query(cases()[1].mesh);
    EXPECT_NEAR(query.winding_number(Vec3(Real(0.6), 0, 0), Real(1e9)), 1, 1e-4);
    EXPECT_NEAR(query.winding_number(Vec3(0, 0, 0), Real(1e9)), 0, 1e-4);
}

TEST(ClosestPoint, IsThatOfAllTrianglesOneByOne) {
    const TriangleMesh& mesh = cases()[2].mesh;
    const MeshQuery query(mesh);
    for (int k = 0; k < 40; ++k) {
        const Vec3 x = point(query.bounds(), k);
        Real nearest = std::numeric_limits<Real>::max();
        for (const auto& t : mesh.triangles) {  // a mesh of one triangle has nothing to skip
            const MeshQuery one({{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}, {}, {}, {{0, 1, 2}}});
            nearest = std::min(nearest, one.closest(x).distance);
        }
        const auto found = query.closest(x);
        EXPECT_EQ(found.distance, nearest);
        EXPECT_NEAR((found.point - x).norm(), found.distance, 1e-6);
    }
}

TEST(ClosestPoint, DoesNotDependOnWhereItStarts) {
    const MeshQuery query(cases()[2].mesh);
    for (int k = 0; k < 500; ++k) {
        const Vec3 x = point(query.bounds(), k);
        const auto plain = query.closest(x),
                   hinted = query.closest(x, query.closest(point(query.bounds(), k + 1)).triangle);
        EXPECT_EQ(plain.distance, hinted.distance);
        EXPECT_EQ(plain.triangle, hinted.triangle);
    }
}

TEST(ClosestPoint, OnATriangleMinimisesOverItsBarycentricGrid) {
    // The grid of 200 steps misses the minimum by an edge/200 at most, never beats it.
    for (int k = 0; k < 200; ++k) {
        const auto v = [&](int n) {
            return Vec3f(float(random_unit(k, n, 0, 0)), float(random_unit(k, n, 0, 1)),
                         float(random_unit(k, n, 0, 2)));
        };
        const MeshQuery one({{v(0), v(1), v(2)}, {}, {}, {{0, 1, 2}}});
        const Vec3f x = 3 * v(3) - Vec3f::Constant(1);
        float nearest = 1e9f;
        for (int i = 0; i <= 200; ++i)
            for (int j = 0; i + j <= 200; ++j)
                nearest = std::min(
                    nearest, (v(0) + (v(1) - v(0)) * float(i) / 200.f + (v(2) - v(0)) * float(j) / 200.f - x).norm());
        const Real d = one.closest(x.cast<Real>()).distance;
        EXPECT_LE(d, nearest + 1e-5);
        EXPECT_GE(d, nearest - 0.015);
    }
}

TEST(ClosestPoint, OnASliverIsExactToRounding) {
    // Triangles of 6 mm by 2 m, as of a cylinder in many steps, turned at random, from any corner. A place just above one
    // is as far from it as it is high, to the rounding of coordinates of a metre.
    for (int k = 0; k < 1500; ++k) {
        const auto u = [&](int n) { return random_unit(k, 11, 0, n); };
        const Eigen::Matrix3d turn =
            Eigen::Quaterniond(u(0) - 0.5, u(1) - 0.5, u(2) - 0.5, u(3) - 0.5).normalized().toRotationMatrix();
        const auto at = [&](double x, double y, double z) { return Vec3f((turn * Vec3d(x, y, z)).cast<float>()); };
        const Index first = static_cast<Index>(k % 3);
        const MeshQuery one(
            {{at(0, 0, 0), at(0.006, 0, 0), at(0, 0, 2)}, {}, {}, {{first, (first + 1) % 3, (first + 2) % 3}}});
        const double part = u(4), high = 1e-3 * u(5), up = 1.9 * (1 - part) * u(6);
        EXPECT_NEAR(one.closest(at(0.006 * part, high, up).cast<Real>()).distance, high, 2e-6);
    }
}

TEST(MeshQuery, RefusesWhatIsNoSurface) {
    EXPECT_THROW(MeshQuery({}), InputError);
    EXPECT_THROW(MeshQuery({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}, {}, {{0, 1, 3}}}), InputError);
    EXPECT_THROW(MeshQuery({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {}, {}, {{0, 1, 2}}}), InputError);
    EXPECT_THROW(
        MeshQuery({{{0, 0, 0}, {1, 0, 0}, {0, std::numeric_limits<float>::quiet_NaN(), 0}}, {}, {}, {{0, 1, 2}}}),
        InputError);
}

TEST(MeshShape, TurnsAnInsideOutMeshRound) {
    TriangleMesh mesh = cases()[0].mesh;
    flip_mesh(mesh);
    EXPECT_NEAR(mesh_shape(mesh).distance(Vec3(0, 0, 0)), -0.8, 1e-3);
}

TEST(MeshShape, GivesTheSameDistancesInARowAsOneByOne) {
    const Shape shape = scaled(mesh_shape(cases()[2].mesh), 2);
    std::vector<Vec3> x;
    for (int k = 0; k < 5000; ++k)
        x.push_back(Vec3(Real(k) / 2500 - 1, Real(0.3 * std::sin(k * 0.01)), Real(0.3 * std::cos(k * 0.013))));
    std::vector<Real> d(x.size());
    shape.node().distances(x.data(), d.data(), x.size());
    for (std::size_t k = 0; k < x.size(); ++k) ASSERT_EQ(d[k], shape.distance(x[k]));
}

TEST(MeshQuery, OfAPlaceThatIsNoneFindsATriangleAtTheLargestDistance) {
    const MeshQuery query(cases()[0].mesh);
    const Real none = std::numeric_limits<Real>::quiet_NaN(), endless = std::numeric_limits<Real>::infinity();
    for (const Real x : {none, endless, -endless, std::numeric_limits<Real>::max()}) {
        const MeshQuery::Closest closest = query.closest(Vec3(x, 0, 0));
        EXPECT_LT(closest.triangle, query.mesh().triangles.size()) << x;
        EXPECT_GT(closest.distance, 1e18) << x;
    }
}

TEST(SampledShape, IsNearTheShapeInTheBandAndOfTheRightSignEverywhere) {
    // Trilinear interpolation of a function with slope 1: second order, cell^2/8 times the curvature 1/0.25 and the
    // medial axis's kinks away from the surface; 0.05 cells near it.
    const Shape exact = torus(0.6, 0.25);
    const double cell = 0.02;
    const Shape grid = sampled(exact, cell, 3 * cell);
    for (int k = 0; k < 50000; ++k) {
        const Vec3 x = point(*exact.bounds(), k);
        const Real d = exact.distance(x), e = grid.distance(x);
        if (std::abs(d) < 3 * cell) {
            ASSERT_NEAR(e, d, 0.05 * cell);
        }
        if (std::abs(d) > 0.05 * cell) {
            ASSERT_EQ(e < 0, d < 0);
        }
    }
}

TEST(SampledShape, OfARoomNeedsABoxAndIsAnUpperBoundOutOfIt) {
    const Shape room = inverted(box({1, 1, 1}));
    EXPECT_THROW(sampled(room, 0.05, 0.1), InputError);
    const Shape grid = sampled(room, 0.05, 0.1, Box3{Vec3(-1, -1, -1), Vec3(1, 1, 1)});
    EXPECT_NEAR(grid.distance(Vec3(Real(0.45), 0, 0)), 0.05, 1e-5);
    EXPECT_LT(grid.distance(Vec3(Real(0.7), 0, 0)), 0);
    EXPECT_THROW(sampled(sphere(1), 1e-7, 1), InputError);
}

TEST(SampledShape, OfAMeshAgreesWithTheMesh) {
    const Case& c = cases()[2];
    const double cell = 0.03;
    const Shape exact = mesh_shape(c.mesh), grid = sampled(exact, cell, 2 * cell);
    for (int k = 0; k < 3000; ++k) {
        const Vec3 x = point(*exact.bounds(), k);
        const Real d = exact.distance(x);
        if (std::abs(d) < cell) {
            ASSERT_NEAR(grid.distance(x), d, 0.5 * cell);
        }  // medial axes of legs and horns pass within the band
        if (std::abs(d) > cell) {
            ASSERT_EQ(grid.distance(x) < 0, d < 0);
        }
    }
}

}  // namespace
}  // namespace thixo
