// The side of a sheet a place far from its surfels is on.
#include "render/sheet_field.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "tests/render/surfel_shapes.h"

namespace thixo::render {
namespace {

/// A ball of this many discs, pressed flat along z.
SurfelCloud pressed_ball(std::size_t count, float flat) {
    SurfelCloud cloud;
    const float radius = std::sqrt(4 * float(kPi) / float(count));
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3f p = shapes::fibonacci(i, count);
        shapes::add_disc(cloud, Vec3f(p.x(), p.y(), flat * p.z()), Vec3f(p.x(), p.y(), p.z() / flat).normalized(),
                         radius);
    }
    return cloud;
}

/// The reference: the height over the plane of the nearest disc. Zero where another disc is as near.
float nearest_height(const SurfelCloud& cloud, const Vec3f& x) {
    float best = 1e30f, height = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Vec3f n = cloud.axis1[i].cross(cloud.axis2[i]).normalized();
        const float r2 = (cloud.position[i] - x).squaredNorm(), h = n.dot(x - cloud.position[i]);
        if (r2 < best * (1 - 1e-5f))
            height = h;
        else if (r2 < best * (1 + 1e-5f) && (h > 0) != (height > 0))
            height = 0;
        best = std::min(best, r2);
    }
    return height;
}

/// How many of 2000 places in a cube about the sheet it gets wrong, and how many were asked.
std::pair<int, int> wrong_sides(const SurfelCloud& cloud) {
    std::vector<Index> all(cloud.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
    const SheetField field(cloud, all);
    int wrong = 0, asked = 0;
    for (std::uint64_t k = 0; k < 2000; ++k) {
        const auto u = [&](int use) { return float(3 * random_unit(7, k, 0, use) - 1.5); };
        const Vec3f x(u(0), u(1), u(2));
        const float expected = nearest_height(cloud, x);
        if (std::abs(expected) < 1e-3f) continue;
        ++asked;
        wrong += (field.distance(x) > 0) != (expected > 0);
    }
    return {wrong, asked};
}

TEST(SheetField, FarPlacesAreOnTheSideOfTheNearestSurfel) {
    for (const float flat : {1.0f, 0.3f, 0.05f}) {
        const auto [wrong, asked] = wrong_sides(pressed_ball(4000, flat));
        EXPECT_GT(asked, 1800) << flat;
        EXPECT_EQ(wrong, 0) << flat;
    }
}

TEST(SheetField, AnOpenSheetHasTheSidesOfItsRimBeyondIt) {
    SurfelCloud bowl;
    const SurfelCloud ball = pressed_ball(4000, 1);
    for (std::size_t i = 0; i < ball.size(); ++i)
        if (ball.position[i].z() < -0.2f)
            shapes::add_disc(bowl, ball.position[i], ball.axis1[i].cross(ball.axis2[i]).normalized(), 0.056f);
    const auto [wrong, asked] = wrong_sides(bowl);
    EXPECT_GT(asked, 1800);
    EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace thixo::render
