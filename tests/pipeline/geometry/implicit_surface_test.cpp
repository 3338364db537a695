#include "pipeline/geometry/implicit_surface.h"

#include <gtest/gtest.h>

#include <functional>

#include "pipeline/base/random.h"
#include "tests/pipeline/geometry/sampled_surfaces.h"

namespace thixo {
namespace {

// Support in spacings of the samples: some 20 surfels blend at a point.
constexpr double kSupport = 2.5;

struct Cloud {
    fixture::Samples samples;
    ImplicitSurface surface;
    double support;
    explicit Cloud(fixture::Samples s) : samples(std::move(s)), support(kSupport * samples.spacing) {
        surface.build(samples.position, samples.normal, Real(support));
    }
};

Vec3 random_direction(std::uint64_t id) {
    const double z = 2 * random_unit(5, id, 0, 0) - 1, angle = 2 * kPi * random_unit(5, id, 0, 1),
                 ring = std::sqrt(1 - z * z);
    return Vec3(Real(ring * std::cos(angle)), Real(ring * std::sin(angle)), Real(z));
}

double torus_distance(const Vec3& x, double radius, double tube) {
    return std::hypot(std::hypot(x.x(), x.y()) - radius, double(x.z())) - tube;
}

/// Root mean square of distance(p) over the feet p of points near the surface, projected orthogonally.
double projection_error(const Cloud& cloud, const std::function<double(const Vec3&)>& distance) {
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < cloud.samples.position.size(); i += 7) {
        const Vec3 start = cloud.samples.position[i] + Real(0.3 * cloud.support) * random_direction(i);
        const auto foot = cloud.surface.project_orthogonal(start);
        EXPECT_EQ(foot.status, SurfaceStatus::converged);
        sum += square(distance(foot.position));
        ++count;
    }
    return std::sqrt(sum / count);
}

// The blend of tangent planes misses a surface of curvature k by about k h_s^2 / 10: second order. Between 1.7 and 2.4
// per halving of the spacing leaves room for the pattern of the samples only.
void expect_second_order(const std::vector<double>& spacing, const std::vector<double>& error) {
    for (std::size_t k = 1; k < spacing.size(); ++k) {
        const double order = std::log(error[k - 1] / error[k]) / std::log(spacing[k - 1] / spacing[k]);
        EXPECT_GT(order, 1.7) << "between spacings " << spacing[k - 1] << " and " << spacing[k];
        EXPECT_LT(order, 2.4);
    }
}

TEST(ImplicitSurface, ConvergesToASphereAtSecondOrder) {
    std::vector<double> spacing, error;
    for (const int n : {500, 2000, 8000, 32000}) {
        const Cloud cloud(fixture::sphere(n, 1));
        spacing.push_back(cloud.samples.spacing);
        error.push_back(projection_error(cloud, [](const Vec3& p) { return p.norm() - 1.0; }));
        // Sag of a spherical cap under the poly6 weights: h_s^2 / (10 R); twice that is no longer this surface.
        EXPECT_LT(error.back(), 0.2 * square(cloud.support));
    }
    expect_second_order(spacing, error);
}

TEST(ImplicitSurface, ConvergesToATorusAtSecondOrder) {
    std::vector<double> spacing, error;
    for (const double s : {0.08, 0.04, 0.02}) {
        const Cloud cloud(fixture::torus(s, 1, 0.5));
        spacing.push_back(s);
        error.push_back(projection_error(cloud, [](const Vec3& p) { return torus_distance(p, 1, 0.5); }));
    }
    expect_second_order(spacing, error);
}

TEST(ImplicitSurface, GradientMatchesDifferences) {
    const Cloud cloud(fixture::torus(0.05, 1, 0.4));
    const double step = 1e-5 * cloud.support;
    for (std::size_t i = 0; i < cloud.samples.position.size(); i += 31) {
        const Vec3 x = cloud.samples.position[i] + Real(0.4 * cloud.support) * random_direction(i);
        const auto sample = cloud.surface.evaluate_gradient(x);
        ASSERT_TRUE(sample);
        for (int axis = 0; axis < 3; ++axis) {
            const Vec3 e = Real(step) * Vec3::Unit(axis);
            const double slope =
                (cloud.surface.evaluate(x + e)->value - cloud.surface.evaluate(x - e)->value) / (2 * step);
            // F has curvatures of 1/h_s: central differences are good to (step/h_s)^2 = 1e-10, rounding to 1e-11.
            EXPECT_NEAR(sample->gradient[axis], slope, 1e-7);
        }
    }
}

TEST(ImplicitSurface, IsUndefinedOutsideAllSupports) {
    const Cloud cloud(fixture::sphere(500, 1));
    EXPECT_FALSE(cloud.surface.evaluate(Vec3(0, 0, 0)));
    EXPECT_FALSE(cloud.surface.evaluate(Vec3(0, 0, Real(1.01 + cloud.support))));
    EXPECT_EQ(cloud.surface.project_simple(Vec3(0, 0, 0)).status, SurfaceStatus::left_domain);
    EXPECT_EQ(cloud.surface.root(Vec3(0, 0, 0), Vec3(0, 0, 1)).status, SurfaceStatus::left_domain);
}

TEST(ImplicitSurface, IsUndefinedWhereNormalsCancel) {
    ImplicitSurface surface;
    surface.build(std::vector<Vec3>{{-1, 0, 0}, {1, 0, 0}}, std::vector<Vec3>{{-1, 0, 0}, {1, 0, 0}}, 3);
    EXPECT_FALSE(surface.evaluate(Vec3(0, 0, 0)));
}

TEST(ImplicitSurface, AllProjectionsEndOnTheSurface) {
    const Cloud cloud(fixture::torus(0.05, 1, 0.4));
    for (std::size_t i = 0; i < cloud.samples.position.size(); i += 11) {
        const Vec3 x = cloud.samples.position[i] + Real(0.4 * cloud.support) * random_direction(i);
        for (const auto& foot : {cloud.surface.project_simple(x), cloud.surface.project_almost_orthogonal(x),
                                 cloud.surface.project_orthogonal(x)}) {
            ASSERT_EQ(foot.status, SurfaceStatus::converged);
            // The last step was under 1e-4 of the support, and steps shrink at least by half each time.
            EXPECT_LT(std::abs(cloud.surface.evaluate(foot.position)->value), 2e-4 * cloud.support);
        }
    }
}

TEST(ImplicitSurface, TheOrthogonalProjectionEndsBelowItsStart) {
    const Cloud cloud(fixture::torus(0.05, 1, 0.4));
    for (std::size_t i = 0; i < cloud.samples.position.size(); i += 11) {
        const Vec3 x = cloud.samples.position[i] + Real(0.4 * cloud.support) * random_direction(i);
        const auto foot = cloud.surface.project_orthogonal(x, {}, {Real(1e-7), 60});
        ASSERT_EQ(foot.status, SurfaceStatus::converged);
        const Vec3 gradient = cloud.surface.evaluate_gradient(foot.position)->gradient.normalized();
        const Vec3 way = x - foot.position;
        // The way is parallel to grad F: its part across vanishes with the tolerance of the iteration.
        EXPECT_LT((way - gradient * gradient.dot(way)).norm(), 1e-5 * cloud.support);
    }
}

TEST(ImplicitSurface, ReportsTheCapOnSteps) {
    const Cloud cloud(fixture::sphere(2000, 1));
    const auto foot = cloud.surface.project_orthogonal(Vec3(0, 0, Real(1 + 0.5 * cloud.support)), {}, {Real(1e-12), 1});
    EXPECT_EQ(foot.status, SurfaceStatus::step_cap);
    EXPECT_EQ(foot.steps, 1);
}

TEST(ImplicitSurface, RootAlongARadiusIsWhereTheProjectionIs) {
    const Cloud cloud(fixture::sphere(8000, 1));
    for (std::uint64_t i = 0; i < 100; ++i) {
        const Vec3 d = random_direction(i);
        const Real reach = Real(0.6 * cloud.support);
        const auto root = cloud.surface.root((1 - reach) * d, (1 + reach) * d, {}, {Real(1e-8), 50});
        ASSERT_EQ(root.status, SurfaceStatus::converged);
        const Vec3 x = (1 - reach + root.t * 2 * reach) * d;
        EXPECT_NEAR(cloud.surface.evaluate(x)->value, 0, 1e-7 * cloud.support);
    }
    const auto none = cloud.surface.root(Vec3(0, 0, Real(1.01)), Vec3(0, 0, Real(1.05)));
    EXPECT_EQ(none.status, SurfaceStatus::no_root);
}

// Two sheets nearer to each other than the support: without a choice they blend to nonsense, with a reference normal
// each is itself.
TEST(ImplicitSurface, AReferenceNormalKeepsTheSidesOfAThinSheetApart) {
    std::vector<Vec3> position, normal;
    const Real half = Real(0.02);
    for (int side : {-1, 1})
        for (int y = -20; y <= 20; ++y)
            for (int x = -20; x <= 20; ++x) {
                position.emplace_back(Real(0.05 * x), Real(0.05 * y), Real(side) * half);
                normal.emplace_back(Real(0), Real(0), Real(side));
            }
    ImplicitSurface surface;
    surface.build(position, normal, Real(0.15));
    for (const Real z : {Real(-0.03), Real(0), Real(0.05)}) {
        const Vec3 x(Real(0.013), Real(-0.021), z);
        EXPECT_NEAR(surface.evaluate(x, {.reference = Vec3(0, 0, 1)})->value, z - half, 1e-12);
        EXPECT_NEAR(surface.evaluate(x, {.reference = Vec3(0, 0, -1)})->value, -half - z, 1e-12);
    }
}

TEST(ImplicitSurface, AGroupSeesItsOwnSurfelsOnly) {
    ImplicitSurface surface;
    surface.build(std::vector<Vec3>{{0, 0, 0}, {0, 0, Real(0.1)}}, std::vector<Vec3>{{0, 0, 1}, {0, 0, 1}}, 1,
                  std::vector<std::int32_t>{3, 4});
    EXPECT_NEAR(surface.evaluate(Vec3(0, 0, 0), {.group = 3})->value, 0, 1e-15);
    EXPECT_NEAR(surface.evaluate(Vec3(0, 0, 0), {.group = 4})->value, -0.1, 1e-15);
    EXPECT_FALSE(surface.evaluate(Vec3(0, 0, 0), {.group = 5}));
}

}  // namespace
}  // namespace thixo
