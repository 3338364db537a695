#include "render/preview/colour_map.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "pipeline/geometry/colour_code.h"

namespace thixo::preview {
namespace {

// CIE lightness L* of a display colour, from its luminance by Rec.709 weights: a measure the map was not built from.
double cie_lightness(const Vec3f& colour) {
    const Vec3f c = linear_from_srgb(colour);
    const double y = 0.2126 * c.x() + 0.7152 * c.y() + 0.0722 * c.z();
    return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}

TEST(ColourMap, GrowsEvenlyInLightness) {
    const double low = cie_lightness(map_colour(0)), high = cie_lightness(map_colour(1));
    EXPECT_GT(high - low, 60);  // readable in grey
    for (int i = 0; i < 16; ++i) {
        const double step = cie_lightness(map_colour((i + 1) / 16.0)) - cie_lightness(map_colour(i / 16.0));
        // OKLab and CIELAB lightness agree only roughly for saturated colours: each sixteenth within a half of an even
        // share.
        EXPECT_GT(step, 0.5 * (high - low) / 16) << i;
        EXPECT_LT(step, 1.5 * (high - low) / 16) << i;
    }
}

TEST(ColourMap, StaysInsideTheDisplayAndClampsValues) {
    for (int i = -10; i <= 110; ++i) {
        const Vec3f c = map_colour(i / 100.0);
        EXPECT_GE(c.minCoeff(), 0);
        EXPECT_LE(c.maxCoeff(), 1);
    }
    EXPECT_EQ(map_colour(-5), map_colour(0));
    EXPECT_EQ(map_colour(5), map_colour(1));
    EXPECT_EQ(map_colour(std::numeric_limits<double>::quiet_NaN()), Vec3f(1, 0, 1));
}

TEST(ColourMap, GivesTheFirstTenCategoriesColoursOfTheirOwn) {
    for (int a = 0; a < 10; ++a)
        for (int b = 0; b < a; ++b) EXPECT_GT((category_colour(a) - category_colour(b)).norm(), 0.1f) << a << " " << b;
}

}  // namespace
}  // namespace thixo::preview
