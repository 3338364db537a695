#include "pipeline/geometry/kernels.h"

#include <gtest/gtest.h>

#include <functional>

namespace thixo {
namespace {

constexpr double kSupport = 0.037;

/// Integral over the ball of radius h of a function of the distance, by the midpoint rule: its error falls as 1/n^2.
double integrate(const std::function<double(double)>& f) {
    constexpr int n = 20000;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double r = kSupport * (i + 0.5) / n;
        sum += 4 * kPi * r * r * f(r) * kSupport / n;
    }
    return sum;
}

/// Central difference; the step is the cube root of the rounding unit, the best trade of the two errors.
double difference(const std::function<double(double)>& f, double r) {
    const double step = 6e-6 * kSupport;
    return (f(r + step) - f(r - step)) / (2 * step);
}

// The quadrature is good to 1e-8, constants and arithmetic to 1e-15 (this test runs with double state).
constexpr double kQuadrature = 1e-5;

TEST(Kernels, IntegrateToOneOverTheirBall) {
    const Poly6 poly6(kSupport);
    const Spiky spiky(kSupport);
    const ViscosityKernel viscosity(kSupport);
    EXPECT_NEAR(integrate([&](double r) { return poly6.value(r * r); }), 1, kQuadrature);
    EXPECT_NEAR(integrate([&](double r) { return spiky.value(r); }), 1, kQuadrature);
    EXPECT_NEAR(integrate([&](double r) { return viscosity.value(r); }), 1, kQuadrature);
    EXPECT_NEAR(integrate([&](double r) { return ConvexSpline(kSupport).value(r); }), 1, kQuadrature);
}

TEST(Kernels, VanishBeyondTheSupport) {
    for (const double r : {(1 + 1e-12) * kSupport, 1.001 * kSupport, 7.0}) {
        EXPECT_EQ(Poly6(kSupport).value(r * r), 0);
        EXPECT_EQ(Poly6(kSupport).gradient_factor(r * r), 0);
        EXPECT_EQ(Spiky(kSupport).value(r), 0);
        EXPECT_EQ(Spiky(kSupport).derivative(r), 0);
        EXPECT_EQ(ConvexSpline(kSupport).value(r), 0);
        EXPECT_EQ(ConvexSpline(kSupport).derivative(r), 0);
        EXPECT_EQ(ViscosityKernel(kSupport).value(r), 0);
        EXPECT_EQ(ViscosityKernel(kSupport).derivative(r), 0);
        EXPECT_EQ(ViscosityKernel(kSupport).laplacian(r), 0);
    }
}

TEST(Kernels, GradientsMatchDifferences) {
    const Poly6 poly6(kSupport);
    const Spiky spiky(kSupport);
    const ViscosityKernel viscosity(kSupport);
    const ConvexSpline spline(kSupport);
    // Slopes are of the size 1/h^4; differences are good to 1e-10 of that, near the pole of w_visc to 1e-6.
    const double scale = 1 / square(square(kSupport));
    for (double q = 0.05; q < 0.99; q += 0.047) {
        const double r = q * kSupport;
        EXPECT_NEAR(poly6.gradient_factor(r * r) * r, difference([&](double s) { return poly6.value(s * s); }, r),
                    1e-8 * scale);
        EXPECT_NEAR(spiky.derivative(r), difference([&](double s) { return spiky.value(s); }, r), 1e-8 * scale);
        EXPECT_NEAR(spline.derivative(r), difference([&](double s) { return spline.value(s); }, r), 1e-8 * scale);
        EXPECT_NEAR(viscosity.derivative(r), difference([&](double s) { return viscosity.value(s); }, r), 1e-5 * scale);
    }
}

TEST(Kernels, TheViscosityLaplacianIsTheDivergenceOfItsGradient) {
    const ViscosityKernel w(kSupport);
    const double scale = 1 / (cube(kSupport) * square(kSupport));
    for (double q = 0.05; q < 0.99; q += 0.047) {
        const double r = q * kSupport;
        const double flux = difference([&](double s) { return s * s * w.derivative(s); }, r) / (r * r);
        EXPECT_NEAR(w.laplacian(r), flux, 1e-6 * scale);
        EXPECT_GT(w.laplacian(r), 0);
    }
}

// This is what makes sum_j V_j (A_j - A_i) lap w the Laplacian with constant 1.
TEST(Kernels, TheViscosityLaplacianHasSecondMomentSix) {
    const ViscosityKernel w(kSupport);
    EXPECT_NEAR(integrate([&](double r) { return r * r * w.laplacian(r); }), 6, 6 * kQuadrature);
}

}  // namespace
}  // namespace thixo
