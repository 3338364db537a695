#include "pipeline/geometry/local_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/geometry/gradient_noise.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/sloped_shape.h"

namespace thixo {
namespace {

struct Named {
    const char* name;
    Shape shape;
};

/// Shapes of many parts: every node that leaves parts out, blended and sharp, under every node that passes it on.
std::vector<Named> shapes() {
    const Shape arm =
        swept({{{0.1, 0, 0.3}, 0.08}, {{0.4, 0.1, 0.1}, 0.06}, {{0.7, 0, 0.3}, 0.04}, {{0.9, 0.2, 0}, 0.03}});
    const Shape ball = translated(sphere(0.15), {0.2, 0.1, 0.5});
    const Shape arms = repeated(arm, 5, {0, 0, 0}, 72), blended = repeated(arm, 5, {0, 0, 0}, 72, 0.05);
    const Shape body = union_of({arms, ellipsoid({0.3, 0.2, 0.25}), ball, translated(ball, {-0.4, 0, 0})}, 0.06);
    const Shape eyes = translated(sphere(0.05), {0.3, 0.15, 0.55});
    const Shape bitten = difference_of({body, eyes, translated(eyes, {-0.4, 0, 0})}, 0.02);
    return {{"arm", arm},
            {"copies", arms},
            {"blended copies", blended},
            {"body", body},
            {"bitten", bitten},
            {"sharp", difference_of({union_of({arms, ball}), eyes})},
            {"common", intersection_of({body, ellipsoid({1, 1, 0.4}), sphere(0.8)}, 0.03)},
            {"mirrored", mirrored(bitten, {1, 0.2, 0}, -0.3)},
            {"placed", transformed(bitten, 0.8, rotation_from_degrees({20, 30, 40}), {0.1, -0.1, 0.2})},
            {"grown", offset(bitten, 0.02)},
            {"shrunk", offset(bitten, -0.02)},
            {"shell", shell(body, 0.03)},
            {"room in a ball", intersection_of({sphere(0.9), inverted(body)})},
            {"rough", roughened(bitten, 0.02, 0.15, 3)}};
}

Vec3 random_point(std::uint64_t k, double extent) {
    const auto u = [&](int axis) { return (random_unit(5, k, 0, axis) - 0.5) * 2 * extent; };
    return Vec3d(u(0), u(1), u(2)).cast<Real>();
}

TEST(LocalShape, HasTheSameDistanceInItsBall) {
    for (const auto& [name, shape] : shapes()) {
        int left_out = 0;
        for (int k = 0; k < 300; ++k) {
            const Ball3 ball{random_point(std::uint64_t(k), 1),
                             Real(0.01 + 0.1 * random_unit(6, std::uint64_t(k), 0, 0))};
            const auto part = parts_within(shape, ball);
            if (!part) continue;
            ++left_out;
            for (int j = 0; j < 20; ++j) {
                Vec3 way = random_point(std::uint64_t(1000 * k + j), 1);
                const Vec3 x = ball.centre + ball.radius * way / std::max(way.norm(), Real(1));
                // Parts that are left out change nothing, not even rounding.
                EXPECT_EQ(part->distance(x), shape.distance(x)) << name;
            }
        }
        EXPECT_GT(left_out, 100) << name;
    }
}

TEST(LocalShape, BlocksHaveTheSameDistanceEverywhere) {
    for (const auto& [name, shape] : shapes())
        for (const double block : {0.05, 0.3}) {
            const Shape blocks = by_blocks(shape, block);
            EXPECT_NE(&blocks.node(), &shape.node()) << name;
            for (int k = 0; k < 5000; ++k) {
                const Vec3 x = random_point(std::uint64_t(k), 1.6);
                ASSERT_EQ(blocks.distance(x), shape.distance(x)) << name << " at " << x.transpose();
            }
        }
}

TEST(LocalShape, WhatHasOnePartIsLeftAlone) {
    const Shape whole = sphere(1), room = inverted(sphere(1));
    EXPECT_EQ(&by_blocks(whole, 0.1).node(), &whole.node());
    EXPECT_EQ(&by_blocks(room, 0.1).node(), &room.node());  // has no bounds
    EXPECT_THROW(by_blocks(whole, 0), InputError);
}

TEST(SlopedShape, GradientIsThatOfTheDistance) {
    auto all = shapes();
    all.push_back({"sphere", sphere(0.5)});
    all.push_back({"plane", plane({1, 2, 3}, 0.1)});
    all.push_back({"ellipsoid", ellipsoid({0.9, 0.5, 0.3})});
    all.push_back({"blocks", by_blocks(shapes()[4].shape, 0.1)});
    all.push_back({"box", box({1, 0.8, 0.6})});  // by differences
    const Real step = sizeof(Real) == 4 ? Real(1e-3) : Real(1e-5);
    for (const auto& [name, shape] : all) {
        const SlopedShape sloped(shape);
        int wrong = 0;
        const int count = 3000;
        for (int k = 0; k < count; ++k) {
            const Vec3 x = random_point(std::uint64_t(k), 1.2);
            Vec3 g, central;
            const Real d = sloped.sloped(x, step, g);
            for (int axis = 0; axis < 3; ++axis) {
                Vec3 e = Vec3::Zero();
                e[axis] = step;
                central[axis] = (shape.distance(x + e) - shape.distance(x - e)) / (2 * step);
            }
            // A distance by differences is exact to their curvature, and otherwise to rounding.
            EXPECT_NEAR(double(d), double(shape.distance(x)), sloped.knows_slope() ? 1e-6 : double(step)) << name;
            wrong += (g - central).norm() > Real(0.02);
        }
        // There is no gradient on edges and where two parts are equally near: a few places in a thousand.
        EXPECT_LT(wrong, count / 50) << name;
    }
}

TEST(SlopedShape, NoiseIsTheSameWithAndWithoutItsGradientWhereverItWasAskedBefore) {
    for (int k = 0; k < 2000; ++k) {
        const Vec3f p = random_point(std::uint64_t(k), 20).cast<float>();
        const float alone = fractal_noise_value(p, 4);
        // Places near 200 are rounded to 1.5e-5, and the noise is as steep as 1 in each octave.
        EXPECT_NEAR(fractal_noise(p, 4).value, alone, 1e-5f);
        fractal_noise_value(p + Vec3f(3, 0, 0), 4);
        EXPECT_EQ(fractal_noise_value(p, 4), alone);
    }
}

}  // namespace
}  // namespace thixo
