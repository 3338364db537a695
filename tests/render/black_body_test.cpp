// Matter that glows by its heat: colours and luminances that others have published.
#include "render/black_body.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/warp.h"

namespace thixo::render {
namespace {

TEST(BlackBody, HasTheColoursOfThePlanckianLocus) {
    // Kelvin, x, y of the CIE 1931 diagram. 2856 K is illuminant A (ISO/CIE 11664-2).
    constexpr double kLocus[][3] = {{1000, 0.6528, 0.3444}, {1500, 0.5857, 0.3931}, {2000, 0.5267, 0.4133},
                                    {2856, 0.4476, 0.4074}, {5000, 0.3451, 0.3516}, {6500, 0.3135, 0.3237}};
    for (const auto& [kelvin, x, y] : kLocus) {
        const Vec3d xyz = black_body_xyz(kelvin);
        EXPECT_NEAR(xyz.x() / xyz.sum(), x, 0.005) << kelvin;
        EXPECT_NEAR(xyz.y() / xyz.sum(), y, 0.005) << kelvin;
    }
}

TEST(BlackBody, OfFreezingPlatinumHasSixtyCandelasASquareCentimetre) {
    // The definition of the candela until 1979. Platinum freezes at 2041.4 K.
    EXPECT_NEAR(683 * black_body_xyz(2041.4).y(), 60e4, 0.01 * 60e4);
}

/// The eye's sensitivity V by another source: the fit of Wyman, Sloan and Shirley 2013, good to a hundredth.
double sensitivity(double nm) {
    const double a = (nm - 568.8) * (nm < 568.8 ? 0.0213 : 0.0247), b = (nm - 530.9) * (nm < 530.9 ? 0.0613 : 0.0322);
    return 0.821 * std::exp(-0.5 * a * a) + 0.286 * std::exp(-0.5 * b * b);
}

double luminance_of(double kelvin) {
    double sum = 0;
    for (double nm = 360.5; nm < 830; ++nm)
        sum += sensitivity(nm) * std::pow(nm, -5) / std::expm1(0.01438776877 / (1e-9 * nm * kelvin));
    return sum;
}

TEST(BlackBody, IsAsBrightAsPlancksLawHasIt) {
    constexpr float kReference = 1473.15f;
    for (const float kelvin : {900.0f, 1100.0f, 1300.0f, 1600.0f, 3000.0f, 6500.0f}) {
        const double ratio = double(luminance(black_body_radiance(kelvin, kReference)));
        const double law = luminance_of(double(kelvin)) / luminance_of(double(kReference));
        EXPECT_NEAR(ratio / law, 1, 0.01) << kelvin;
    }
    EXPECT_NEAR(luminance(black_body_radiance(kReference, kReference)), 1, 1e-6f);
}

TEST(BlackBody, OfTheTableIsThatOfTheLaw) {
    for (double kelvin = 260; kelvin < 90000; kelvin *= 1.037) {
        const double law = black_body_xyz(kelvin).y() / black_body_xyz(2000).y();
        if (law < 1e-30) continue;  // a float goes no further
        EXPECT_NEAR(double(luminance(black_body_radiance(float(kelvin), 2000))) / law, 1, 2e-5) << kelvin;
    }
}

TEST(BlackBody, IsRedWhenCoolAndWhiteWhenHot) {
    float last = 1.1f;
    for (const float kelvin : {800.0f, 1200.0f, 2000.0f, 4000.0f, 6500.0f}) {
        const Vec3f light = black_body_radiance(kelvin, 1500);
        EXPECT_GE(light.minCoeff(), 0) << kelvin;
        EXPECT_LT(light.x() / light.sum(), last) << kelvin;
        last = light.x() / light.sum();
    }
    // White is D65, close to the black body of 6500 K: 0.3135, 0.3237 against 0.3127, 0.3290.
    const Vec3f white = black_body_radiance(6500, 6500);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 0.06f) << c;
    EXPECT_LT(luminance(black_body_radiance(293.15f, 1500)), 1e-15f);  // nothing glows in a room
    EXPECT_EQ(black_body_radiance(0, 1500), Vec3f(0, 0, 0));
}

}  // namespace
}  // namespace thixo::render
