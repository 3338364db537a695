#include "render/view_transform.h"

#include <gtest/gtest.h>

namespace thixo::render {
namespace {

TEST(ViewTransform, IsMonotoneFromBlackToWhite) {
    for (const scene::ViewTransform view : {scene::ViewTransform::srgb, scene::ViewTransform::filmic}) {
        float before = -1;
        for (int i = 0; i <= 20000; ++i) {
            const float y = view_transform(float(i) * 1e-3f, view, 0);
            EXPECT_GE(y, before);
            EXPECT_GE(y, 0);
            EXPECT_LE(y, 1);
            before = y;
        }
        EXPECT_EQ(view_transform(0, view, 0), 0);
        EXPECT_GT(before, 0.99f);
    }
}

TEST(ViewTransform, KeepsMiddleTonesAndOneStopDoubles) {
    for (const scene::ViewTransform view : {scene::ViewTransform::srgb, scene::ViewTransform::filmic}) {
        EXPECT_NEAR(view_transform(0.18f, view, 0), 0.4613f, 1e-3f);  // sRGB of middle grey
        EXPECT_FLOAT_EQ(view_transform(0.2f, view, 1), view_transform(0.4f, view, 0));
    }
}

TEST(ViewTransform, TransparencyIsNotPremultipliedInThePng) {
    Image image(1, 1);
    for (const char* c : {"R", "G", "B"}) image.add(c)[0] = 0.1f;
    image.add("A")[0] = 0.5f;
    const Image8 png = to_display(image, scene::ViewTransform::srgb, 0);
    ASSERT_EQ(png.channels, 4);
    EXPECT_EQ(png.values[3], 128);
    EXPECT_NEAR(png.values[0], 255 * view_transform(0.2f, scene::ViewTransform::srgb, 0), 1);
}

}  // namespace
}  // namespace thixo::render
