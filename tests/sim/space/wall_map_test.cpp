#include "sim/space/wall_map.h"

#include <gtest/gtest.h>

#include "pipeline/geometry/kernels.h"
#include "pipeline/geometry/shapes.h"
#include "sim/space/smoothing.h"

namespace thixo {
namespace {

constexpr Real h = Real(0.02);

// Sums over the wall's volume by midpoints, fine enough that the kernels are smooth between two.
WallIntegrals by_quadrature(const Shape& solid, const Vec3& x, int per_support = 40) {
    const Poly6 poly6(h);
    const Spiky spiky(h);
    const ViscosityKernel viscosity(h);
    WallIntegrals w;
    const Real step = h / static_cast<Real>(per_support);
    double share = 0, laplacian = 0;
    Vec3d gradient(0, 0, 0);
    for (int k = -per_support; k < per_support; ++k)
        for (int j = -per_support; j < per_support; ++j)
            for (int i = -per_support; i < per_support; ++i) {
                const Vec3 r = -step * Vec3(Real(i) + Real(0.5), Real(j) + Real(0.5), Real(k) + Real(0.5));
                const Real length = r.norm();
                if (length >= h || solid.distance(x - r) >= 0) continue;
                share += static_cast<double>(poly6.value(length * length) * cube(step));
                gradient += (spiky.derivative(length) / length * cube(step) * r).cast<double>();
                laplacian += static_cast<double>(viscosity.laplacian(length) * cube(step));
            }
    w.share = static_cast<Real>(share);
    w.gradient = gradient.cast<Real>();
    w.laplacian = static_cast<Real>(laplacian);
    return w;
}

void expect_near(const WallIntegrals& a, const WallIntegrals& b, double tolerance) {
    EXPECT_NEAR(a.share, b.share, tolerance);
    EXPECT_LT((a.gradient - b.gradient).norm() * h,
              1.5 * tolerance);  // the gradient of a half-space at its surface is 1.5/h
    EXPECT_NEAR(a.laplacian * h * h / 15, b.laplacian * h * h / 15, tolerance);
}

TEST(WallMap, HalfSpaceInClosedFormIsTheIntegral) {
    const Shape solid = plane({0, 0, 1}, 0);
    for (const Real part : {-0.7, -0.2, 0.0, 0.25, 0.5, 0.9}) {
        SCOPED_TRACE(part);
        // Midpoints with steps of h/40 miss at most half a step's layer of the wall: share 1.23/h times h/80 at the
        // surface.
        expect_near(half_space_integrals(part * h, h), by_quadrature(solid, Vec3(0, 0, part * h)), 0.016);
    }
}

TEST(WallMap, HalfSpaceHasTheSharesOfAFullAndAnEmptyBall) {
    EXPECT_NEAR(half_space_integrals(0, h).share, 0.5, 1e-6);
    EXPECT_NEAR(half_space_integrals(-h, h).share, 1, 1e-6);
    EXPECT_NEAR(half_space_integrals(h, h).share, 0, 1e-6);
    EXPECT_NEAR(half_space_integrals(-h, h).laplacian, 15 / (h * h), 1e-3 * 15 / (h * h));
}

TEST(WallMap, TablesAgreeWithTheIntegralAtEdgesAndCurves) {
    // Tables are trilinear in cells of h/4, which leaves (h/4)^2/8 times a second derivative. Particles come as near as
    // a fifth of a support. There the second derivatives are about 5/h^2 of the share and 7/h^3 of the gradient. So
    // errors are 0.04 and 0.055/h. Quadrature adds 0.016.
    const Shape solids[] = {box({0.1, 0.1, 0.1}), sphere(0.05),
                            rotated(box({0.1, 0.1, 0.02}), rotation_from_degrees({20, 30, 40}))};
    for (const Shape& solid : solids) {
        const WallMap map(solid, h);
        for (const Vec3& x : {Vec3(0.0567, 0.051, 0.05), Vec3(0.03, 0.05, 0.056), Vec3(0.0555, 0.001, 0.003),
                              Vec3(0.001, 0.002, 0.056), Vec3(-0.01, 0.03, 0.04)})
            if (solid.distance(x) > h / 5) expect_near(map.at(x), by_quadrature(solid, x, 24), 0.055);
    }
}

TEST(WallMap, BetweenTwoFacesBothCount) {
    // The share along a way across the middle between two faces of a tank, or three. Its second difference over a
    // hundredth of a support is below 0.01^2 of the largest second derivative, 40 of the share at a face: 0.005. With a
    // mean of two normals in place of one it is 0.37 at a fifth of a support.
    const WallKernel kernel = Smoothing(h / 2, 2).wall;
    const Real step = h / 100;
    for (const Quatd& turn : {Quatd::Identity(), rotation_from_degrees({20, 30, 40})}) {
        const WallMap map(inverted(rotated(box({0.1, 0.1, 0.1}), turn)), kernel);
        for (const Real d : {h / 5, h / 3, h / 2})
            for (const bool third : {false, true}) {
                const auto share = [&](Real aside) {
                    const Vec3d x(0.05 - double(d + aside), 0.05 - double(d), third ? 0.05 - double(d) : 0.003);
                    return map.at((turn * x).cast<Real>()).share;
                };
                for (const Real x : {-step, -step / 20, -step / 50, Real(0), step / 30, step / 10})
                    EXPECT_LT(std::abs(share(x + step) - 2 * share(x) + share(x - step)), 0.005)
                        << d / h << ", " << x / h << (third ? ", three" : ", two");
            }
    }
}

TEST(WallMap, DistanceAndNormalAreThoseOfTheShape) {
    const Shape solid = inverted(sphere(0.1));
    const WallMap map(solid, h);
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0.6, 0.8, 0), Vec3(-0.36, 0.48, 0.8)}) {
        const Vec3 x = Real(0.092) * direction;
        Vec3 normal;
        // Trilinear in cells of 5 mm of a distance with second derivative 1/radius: (h/4)^2/8 * 2/0.1 = 6e-5 m.
        EXPECT_NEAR(map.distance(x, normal), 0.008, 6.5e-5);
        EXPECT_GT(normal.dot(-direction), 0.999);
    }
    Vec3 normal;
    EXPECT_GE(map.distance(Vec3(0, 0, 0), normal), h);  // far: a lower bound not below the support
}

}  // namespace
}  // namespace thixo
