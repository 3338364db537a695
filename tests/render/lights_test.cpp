#include "render/lights.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace thixo::render {
namespace {

float uniform(std::uint64_t i, std::uint64_t use) { return float(random_unit(5, i, use, 0)); }

/// Irradiance on a surface of normal n, by the light's own samples.
double irradiance(const Light& light, const Vec3f& position, const Vec3f& n) {
    double sum = 0;
    constexpr int count = 20000;
    for (std::uint64_t i = 0; i < count; ++i) {
        const LightSample s = sample_light(light, position, n, {uniform(i, 0), uniform(i, 1)});
        if (s.pdf > 0) sum += double(s.radiance.y() * std::max(0.0f, n.dot(s.direction)) / s.pdf);
    }
    return sum / count;
}

TEST(Lights, ASunHasItsIrradianceAtAnyWidth) {
    for (const double angle : {0.53, 5.0, 40.0}) {
        scene::Light sun;
        sun.type = scene::LightType::sun;
        sun.strength = 7;
        sun.angle = angle;
        EXPECT_NEAR(irradiance(make_light(sun), {0, 0, 0}, {0, 0, 1}), 7, 0.02) << angle;
    }
}

TEST(Lights, AGradientSkyHasTheIrradianceOfItsFormula) {
    // int cos (h + (1 - h) cos) = pi (h + (1 - h) 2/3)
    scene::Light sky;
    sky.strength = 2;
    sky.horizon = {0.4, 0.4, 0.4};
    EXPECT_NEAR(irradiance(make_light(sky), {0, 0, 0}, {0, 0, 1}), 2 * kPi * (0.4 + 0.6 * 2 / 3), 0.02);
    EXPECT_NEAR(irradiance(make_light(sky), {0, 0, 0}, {0, 0, -1}), 2 * kPi * 0.3, 1e-3);
}

TEST(Lights, APointHasItsIntensityOverTheSquareOfTheDistance) {
    scene::Light lamp;
    lamp.type = scene::LightType::point;
    lamp.position = {1, 2, 2};  // 3 m away, at a cosine of 2/3
    lamp.strength = 6;
    EXPECT_NEAR(irradiance(make_light(lamp), {0, 0, 0}, {0, 0, 1}), 6.0 / 9 * 2 / 3, 1e-5);
    EXPECT_EQ(hit_area(make_light(lamp), {0, 0, 0}, Vec3f(1, 2, 2) / 3), std::numeric_limits<float>::infinity());
}

TEST(Lights, ASpotShinesIntoItsConeAndFadesAtItsRim) {
    scene::Light lamp;
    lamp.type = scene::LightType::spot;
    lamp.position = {0, 0, 2};
    lamp.strength = 8;
    lamp.cone = 60;
    lamp.softness = 0.5;
    const Light light = make_light(lamp);
    const auto part = [&](double degrees) {  // of what a point would give
        const Vec3f at(float(2 * std::tan(degrees * kPi / 180)), 0, 0);
        lamp.type = scene::LightType::point;
        return irradiance(light, at, {0, 0, 1}) / irradiance(make_light(lamp), at, {0, 0, 1});
    };
    EXPECT_NEAR(part(0), 1, 1e-5);
    EXPECT_NEAR(part(14.9), 1, 1e-5);
    const double half = (std::cos(15 * kPi / 180) + std::cos(30 * kPi / 180)) / 2;
    EXPECT_NEAR(part(std::acos(half) * 180 / kPi), 0.5, 1e-3);
    EXPECT_EQ(part(30.1), 0);
    EXPECT_EQ(part(80), 0);
}

TEST(Lights, TheDensityOfAChanceHitIsThatOfTheSample) {
    scene::Light lamp;
    lamp.type = scene::LightType::area;
    lamp.position = {0.3, 0.2, 2};
    lamp.direction = {-0.2, 0.1, -1};
    lamp.size = {0.5, 1.5};
    scene::Light sun;
    sun.type = scene::LightType::sun;
    sun.angle = 10;
    scene::Light sky;
    for (const scene::Light& description : {lamp, sun, sky}) {
        const Light light = make_light(description);
        for (std::uint64_t i = 0; i < 500; ++i) {
            const LightSample s = sample_light(light, {0, 0, 0}, {0, 0, 1}, {uniform(i, 0), uniform(i, 1)});
            float distance = s.distance;
            if (!light.infinite()) {
                distance = hit_area(light, {0, 0, 0}, s.direction);
                EXPECT_NEAR(distance, s.distance, 1e-4f);
            }
            EXPECT_NEAR(light_pdf(light, {0, 0, 1}, s.direction, distance), s.pdf, 1e-3f * s.pdf);
        }
    }
}

TEST(Lights, LookAtTheirTarget) {
    scene::Light lamp;
    lamp.position = {1, -2, 3};
    lamp.look_at = Vec3d(0.5, 1, 0.25);
    const Vec3d way = *lamp.look_at - lamp.position;
    for (const scene::LightType type : {scene::LightType::area, scene::LightType::spot}) {
        lamp.type = type;
        const Light light = make_light(lamp);
        EXPECT_LT((light.normal - way.normalized().cast<float>()).norm(), 1e-6f);
        // A ray from the target along the lamp's axis meets the lamp, if that has a size.
        const bool sizeless = light.sizeless();
        const float away = hit_area(light, lamp.look_at->cast<float>(), -light.normal);
        EXPECT_TRUE(sizeless ? std::isinf(away) : std::abs(double(away) - way.norm()) < 1e-5) << away;
        scene::Light aimed = lamp;
        aimed.look_at.reset();
        aimed.direction = way;
        EXPECT_EQ(make_light(aimed).normal, light.normal);
    }
    lamp.type = scene::LightType::sun;  // it is nowhere, and shines down without a direction
    EXPECT_EQ(make_light(lamp).normal, Vec3f(0, 0, 1));
}

TEST(Lights, ARectangleShinesToOneSide) {
    scene::Light lamp;
    lamp.type = scene::LightType::area;
    const Light light = make_light(lamp);
    EXPECT_TRUE(std::isfinite(hit_area(light, {0, 0, 0}, {0, 0, 1})));
    EXPECT_FALSE(std::isfinite(hit_area(light, {0, 0, 6}, {0, 0, -1})));
    EXPECT_FALSE(std::isfinite(hit_area(light, {0.6f, 0, 0}, {0, 0, 1})));
    EXPECT_EQ(sample_light(light, {0, 0, 6}, {0, 0, -1}, {0.5f, 0.5f}).pdf, 0);
}

}  // namespace
}  // namespace thixo::render
