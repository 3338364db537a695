#include "render/noise.h"

#include <gtest/gtest.h>

#include "tests/render/surfel_shapes.h"

namespace thixo::render {
namespace {

Vec3f place(std::uint64_t i) { return 20 * shapes::on_sphere(i, 3) + 5 * shapes::on_sphere(i, 4); }

TEST(Noise, ItsGradientIsTheDifferenceOfItsValues) {
    // Central differences of 1e-2 in float: about 1e-3 for a function of slopes up to 2.
    for (std::uint64_t i = 0; i < 500; ++i) {
        const Vec3f p = place(i);
        for (const int octaves : {1, 3}) {
            const NoiseSample s = fractal_noise(p, octaves);
            for (int k = 0; k < 3; ++k) {
                const Vec3f step = 2e-3f * Vec3f::Unit(k);
                const float slope =
                    (fractal_noise(p + step, octaves).value - fractal_noise(p - step, octaves).value) / 4e-3f;
                EXPECT_NEAR(s.gradient[k], slope, 0.02f);
            }
        }
    }
}

TEST(Noise, HasNoMeanAndIsBounded) {
    double sum = 0;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const float v = gradient_noise(place(i)).value;
        EXPECT_LE(std::abs(v), 1.1f);
        sum += double(v) / 20000;
    }
    EXPECT_NEAR(sum, 0, 0.01);  // values spread by 0.3, so 0.002 is the standard error
}

/// A sphere of surfels turned as a whole; m0 stays.
SurfelSet tumbled(std::size_t n, const Eigen::Quaternionf& turn) {
    SurfelSet set = shapes::one_object(shapes::sphere(n));
    set.rest = set.cloud.position;
    for (std::size_t i = 0; i < set.cloud.size(); ++i) {
        for (auto* a : {&set.cloud.position, &set.cloud.axis1, &set.cloud.axis2, &set.cloud.normal})
            (*a)[i] = turn * (*a)[i];
    }
    return set;
}

TEST(Bumps, DoNotSlipOnABodyThatTumbles) {
    // In 100 poses the m0 at a material point stays that of the first pose, to 0.01 of the surfels' spacing. The bumped
    // normal, turned back, stays to 0.01.
    constexpr std::size_t n = 4000;
    const float spacing = float(shapes::even_spacing(4 * kPi, n));
    const Bump bump{0.02f, 0.3f, 3};
    const Vec3f eye = 3 * Vec3f(0.3f, -0.8f, 0.5f).normalized();
    Attributes first;
    Vec3f normal = Vec3f::Zero();
    for (int pose = 0; pose < 100; ++pose) {
        const Eigen::Quaternionf turn(Eigen::AngleAxisf(0.37f * float(pose), shapes::on_sphere(std::uint64_t(7), 9)));
        const RayScene scene(tumbled(n, turn), {});
        const Vec3f from = turn * eye;
        Hit hit;
        ASSERT_TRUE(scene.intersect({from, -from.normalized()}, {}, hit, true));
        const Vec3f bumped = turn.conjugate() * bumped_normal(bump, hit);
        if (pose == 0) {
            first = hit.attributes;
            normal = bumped;
            EXPECT_GT((bumped - turn.conjugate() * hit.normal).norm(), 0.02f) << "there are bumps";
        }
        EXPECT_LT((hit.attributes.rest - first.rest).norm(), 0.01f * spacing) << pose;
        EXPECT_LT((bumped - normal).norm(), 0.01f) << pose;
    }
}

}  // namespace
}  // namespace thixo::render
