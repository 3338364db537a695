#include "render/preview/preview.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/contract/trim.h"
#include "render/preview/colour_map.h"
#include "render/preview/overlay.h"

// Asked by the leak sanitizer: OSMesa 22.3 keeps some bookkeeping of its drawables (a few kB) for good.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa.so\n"; }

namespace thixo::preview {
namespace {

constexpr int kWidth = 320, kHeight = 240;

Vec3f pixel(const Image8& picture, int x, int y) {
    const std::size_t at = 3 * static_cast<std::size_t>(y * picture.width + x);
    return Vec3f(picture.values[at], picture.values[at + 1], picture.values[at + 2]) / 255.0f;
}

Vec3f background(int y) {
    const float t = 1 - (static_cast<float>(y) + 0.5f) / kHeight;
    return kBackgroundBottom + t * (kBackgroundTop - kBackgroundBottom);
}

constexpr float kOneStep = 1.01f / 255;  // rounding to 8 bits may go either way

double covered_share(const Image8& picture) {
    int covered = 0;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            if ((pixel(picture, x, y) - background(y)).cwiseAbs().maxCoeff() > 2 * kOneStep) ++covered;
    return static_cast<double>(covered) / (picture.width * picture.height);
}

// Shading is a grey factor: the direction of the colour is left.
double angle_between(const Vec3f& a, const Vec3f& b) {
    return std::acos(std::min(1.0f, a.normalized().dot(b.normalized()))) * 180 / kPi;
}

Frame particles_at(const std::vector<Vec3f>& position, const std::vector<float>& radius,
                   const std::vector<float>& heat) {
    Frame frame;
    frame.particles.count = position.size();
    frame.particles.add("P", position);
    frame.particles.add("pscale", radius);
    frame.particles.add("heat", heat);
    return frame;
}

TriangleMesh box_mesh(const Vec3f& lower, const Vec3f& upper) {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.emplace_back(i & 1 ? upper.x() : lower.x(), i & 2 ? upper.y() : lower.y(),
                                   i & 4 ? upper.z() : lower.z());
    const Index faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : faces) {
        mesh.triangles.push_back({f[0], f[1], f[2]});
        mesh.triangles.push_back({f[0], f[2], f[3]});
    }
    return mesh;
}

class PreviewTest : public ::testing::Test {
  protected:
    void SetUp() override {
        ::unsetenv("DISPLAY");
        ::unsetenv("WAYLAND_DISPLAY");
        look_.camera.position = {0, -4, 0};
        look_.camera.look_at = {0, 0, 0};
        look_.camera.fov = 40;
        look_.output.width = kWidth;
        look_.output.height = kHeight;
        options_.grid = options_.labels = false;
    }
    Image8 draw(const Frame& frame, const Meshes& meshes = {}) {
        Image8 picture;
        previewer_.draw(frame, look_, meshes, options_, picture);
        return picture;
    }
    // Of a sphere at distance d before the camera: a disc of radius r/sqrt(d^2 - r^2) in the picture plane at
    // distance 1.
    double sphere_share(double radius, double distance) const {
        const double half = std::tan(0.5 * look_.camera.fov * kPi / 180);
        return kPi * square(radius) / (square(distance) - square(radius)) / (4 * square(half) * kHeight / kWidth);
    }
    Previewer previewer_;
    scene::Look look_;
    PreviewOptions options_;
};

TEST_F(PreviewTest, AnEmptyFrameIsBackground) {
    const Image8 picture = draw({});
    ASSERT_EQ(picture.width, kWidth);
    ASSERT_EQ(picture.height, kHeight);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            ASSERT_LE((pixel(picture, x, y) - background(y)).cwiseAbs().maxCoeff(), kOneStep) << x << " " << y;
}

TEST_F(PreviewTest, ASphereCoversTheAreaOfItsCone) {
    // A pixel along the outline counts whole or not at all. The outline's length in pixels over the area is 2/radius =
    // 3 %. Partly covered pixels that count make it a little more.
    EXPECT_NEAR(covered_share(draw(particles_at({{0, 0, 0}}, {0.5f}, {0}))) / sphere_share(0.5, 4), 1, 0.04);
}

TEST_F(PreviewTest, ManyParticlesInABallCoverItsOutline) {
    std::vector<Vec3f> position;
    for (std::uint64_t i = 0; position.size() < 60'000; ++i) {
        const auto unit = [&](std::uint64_t use) { return static_cast<float>(2 * random_unit(7, i, 0, use) - 1); };
        const Vec3f x(unit(0), unit(1), unit(2));
        if (x.norm() <= 1) position.push_back(0.7f * x);
    }
    const Frame frame =
        particles_at(position, std::vector<float>(position.size(), 0.02f), std::vector<float>(position.size(), 0));
    // The outline lies between the ball of centres and that ball grown by the particles' radius; gaps near it and
    // pixels on it: 3 %.
    const double share = covered_share(draw(frame));
    EXPECT_GT(share, 0.97 * sphere_share(0.70, 4));
    EXPECT_LT(share, 1.03 * sphere_share(0.72, 4));
}

TEST_F(PreviewTest, TheNearestParticleShowsItsValuesColour) {
    // Front to back 1, 0.5, 0; given in an order that is not theirs.
    options_.what = "particles";
    options_.attribute = "heat";
    options_.range = ValueRange{0, 2};
    const Image8 picture =
        draw(particles_at({{0, 0.5f, 0}, {0, -0.5f, 0}, {0, 1.5f, 0}}, {0.3f, 0.3f, 0.3f}, {0.5f, 1.0f, 0.0f}));
    const Vec3f middle = pixel(picture, kWidth / 2, kHeight / 2);
    EXPECT_LT(angle_between(middle, map_colour(0.5)), 1.0);  // 8 bits a channel turn a colour by less than a degree
    EXPECT_GT(angle_between(middle, map_colour(0.25)), 5.0);
    EXPECT_GT(middle.norm(), 0.6f * map_colour(0.5).norm());  // lit, not in the dark
}

TEST_F(PreviewTest, ASurfelCoversTheAreaOfItsEllipse) {
    Frame frame;
    frame.surfels.count = 1;
    frame.surfels.add("P", std::vector<Vec3f>{{0, 0, 0}});
    frame.surfels.add("t1", std::vector<Vec3f>{{0.6f, 0, 0}});
    frame.surfels.add("t2", std::vector<Vec3f>{{0, 0, 0.3f}});
    const double half = std::tan(0.5 * look_.camera.fov * kPi / 180);
    const double share = kPi * 0.6 * 0.3 / square(4.0) / (4 * square(half) * kHeight / kWidth);
    EXPECT_NEAR(covered_share(draw(frame)) / share, 1, 0.05);  // pixels along the outline, as for the sphere
}

TEST_F(PreviewTest, WallsDoNotHideParticles) {
    Frame frame = particles_at({{0, 0, 0}}, {0.5f}, {0});
    options_.attribute = "heat";
    options_.range = ValueRange{-1, 1};
    const Vec3f bare = pixel(draw(frame), kWidth / 2, kHeight / 2);
    const Meshes meshes{{"box", box_mesh({-1, -1, -1}, {1, 1, 1})},
                        {"shell", box_mesh({-1.1f, -1.1f, -1.1f}, {1.1f, 1.1f, 1.1f})}};
    for (const char* asset : {"box", "shell"}) {
        frame.obstacles.emplace_back();
        frame.obstacles.back().asset = asset;
    }
    const Image8 walled = draw(frame, meshes);
    const Vec3f seen = pixel(walled, kWidth / 2, kHeight / 2);
    EXPECT_LT(angle_between(seen, bare), 8.0);     // still its colour,
    EXPECT_GT(seen.norm(), 0.6f * bare.norm());    // still bright behind two plain walls,
    EXPECT_LT(seen.norm(), 0.995f * bare.norm());  // and the walls are there
    const int edge = kWidth / 2 + static_cast<int>(kWidth / 2 * (0.9 / 4) / std::tan(20 * kPi / 180));
    EXPECT_GT((pixel(walled, edge, kHeight / 2) - background(kHeight / 2)).norm(), 0.05f);
}

TEST_F(PreviewTest, ObstaclesStandWhereTheirTransformPutsThem) {
    Frame frame;
    FrameObstacle o;
    o.asset = "box";
    o.transform[3] = 0.8;  // to the right
    frame.obstacles.push_back(o);
    const Image8 picture = draw(frame, {{"box", box_mesh({-0.2f, -0.2f, -0.2f}, {0.2f, 0.2f, 0.2f})}});
    const View view = look_view(look_.camera, 0, kWidth, kHeight);
    const auto differs_at = [&](const Vec3d& x) {
        const Vec2d at = view.project(x);
        const int px = static_cast<int>(at.x() * kWidth), py = static_cast<int>(at.y() * kHeight);
        return (pixel(picture, px, py) - background(py)).norm() > 0.02f;
    };
    EXPECT_TRUE(differs_at({0.8, 0, 0}));
    EXPECT_FALSE(differs_at({0, 0, 0}));
    EXPECT_FALSE(differs_at({-0.8, 0, 0}));
}

TEST_F(PreviewTest, FrontsOfCracksAreLinesOverTheBody) {
    // An arc behind a ball that hides it from the camera. It is seen all the same, and so is its closing line.
    Frame frame = particles_at({{0, 0, 0}}, {0.5f}, {0});
    const Image8 plain = draw(frame);
    frame.fronts = {{.closed = false, .nodes = {{-0.6, 1, 0}, {0, 1, 0.4}, {0.6, 1, 0}}}};
    const View view = look_view(look_.camera, 0, kWidth, kHeight);
    const auto red_at = [&](const Image8& picture, const Vec3d& x) {
        const Vec2d at = view.project(x);
        const Vec3f seen = pixel(picture, static_cast<int>(at.x() * kWidth), static_cast<int>(at.y() * kHeight));
        return (seen - kFrontColour).cwiseAbs().maxCoeff() <= kOneStep;
    };
    const Image8 open = draw(frame);
    for (const auto& node : frame.fronts[0].nodes) EXPECT_TRUE(red_at(open, {node[0], node[1], node[2]}));
    EXPECT_TRUE(red_at(open, {-0.3, 1, 0.2}));
    EXPECT_FALSE(red_at(open, {0, 1, 0}));
    EXPECT_FALSE(red_at(plain, {-0.3, 1, 0.2}));
    frame.fronts[0].closed = true;
    EXPECT_TRUE(red_at(draw(frame), {0, 1, 0}));
    // What is behind the camera, or far beside the picture, is left out.
    frame.fronts = {{.closed = true, .nodes = {{0, -9, 0}, {1, -5, 0}, {1e9, 1, 0}}}};
    EXPECT_EQ(draw(frame).values, plain.values);
}

TEST_F(PreviewTest, EachCrackHasAColourOnBothOfItsFaces) {
    Frame frame;
    frame.bodies = {{.id = 0, .parent = -1, .name = "a", .material = "stone"}};
    frame.surfels.count = 4;
    const std::vector<Vec3f> places{{-0.9f, 0, 0}, {-0.3f, 0, 0}, {0.3f, 0, 0}, {0.9f, 0, 0}};
    frame.surfels.add("P", places);
    frame.surfels.add("t1", std::vector<Vec3f>(4, {0.2f, 0, 0}));
    frame.surfels.add("t2", std::vector<Vec3f>(4, {0, 0, 0.2f}));
    frame.surfels.add("body", std::vector<std::int32_t>(4, 0));
    frame.surfels.add("sheet",
                      std::vector<std::int32_t>{3, kFirstCrackSheet, kFirstCrackSheet + 1, kFirstCrackSheet + 2});
    options_.attribute = "sheet";
    const Image8 picture = draw(frame);
    const View view = look_view(look_.camera, 0, kWidth, kHeight);
    const auto seen = [&](std::size_t k) {
        const Vec2d at = view.project(places[k].cast<double>());
        return pixel(picture, static_cast<int>(at.x() * kWidth), static_cast<int>(at.y() * kHeight));
    };
    EXPECT_LT(angle_between(seen(1), category_colour(0)), 1);
    EXPECT_LT(angle_between(seen(2), seen(1)), 1) << "both faces of one crack";
    EXPECT_LT(angle_between(seen(3), category_colour(1)), 1);
    EXPECT_GT(angle_between(seen(3), seen(1)), 10);
    EXPECT_GT(angle_between(seen(0), seen(1)), 10) << "what is no crack keeps the colour of its material";
}

TEST_F(PreviewTest, EqualInputGivesEqualBytes) {
    std::vector<Vec3f> position;
    for (std::uint64_t i = 0; i < 5000; ++i)
        position.emplace_back(random_unit(1, i, 0, 0) - 0.5, random_unit(1, i, 0, 1) - 0.5,
                              random_unit(1, i, 0, 2) - 0.5);
    const Frame frame = particles_at(position, std::vector<float>(5000, 0.02f), std::vector<float>(5000, 0));
    options_.grid = options_.labels = true;
    const Image8 first = draw(frame);
    draw({});  // what was drawn between leaves no trace
    EXPECT_EQ(first.values, draw(frame).values);
    Image8 other;
    Previewer().draw(frame, look_, {}, options_, other);
    EXPECT_EQ(first.values, other.values);
}

TEST_F(PreviewTest, LabelsWriteOnlyAlongTheTopAndBottom) {
    options_.attribute = "heat";
    const Frame frame = particles_at({{0, 0, 0}, {0.1f, 0, 0}}, {0.1f, 0.1f}, {0, 1});
    const Image8 plain = draw(frame);
    options_.labels = true;
    const Image8 labelled = draw(frame);
    for (int y = 60; y < kHeight - 60; ++y)
        for (int x = 0; x < kWidth; ++x) ASSERT_EQ(pixel(plain, x, y), pixel(labelled, x, y));
    EXPECT_NE(plain.values, labelled.values);
}

TEST_F(PreviewTest, AParticleAroundTheCameraHidesNothing) {
    const Frame frame = particles_at({{0, -4, 0}, {0, 0, 0}}, {1.0f, 0.5f}, {0, 0});
    EXPECT_NEAR(covered_share(draw(frame)) / sphere_share(0.5, 4), 1, 0.04);
}

TEST_F(PreviewTest, PointsThatAreNotFiniteAreLeftOut) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Frame frame = particles_at({{nan, 0, 0}, {0, 0, 0}}, {0.5f, 0.5f}, {nan, 1});
    options_.attribute = "heat";
    EXPECT_NEAR(covered_share(draw(frame)) / sphere_share(0.5, 4), 1, 0.04);
}

TEST_F(PreviewTest, AnUnknownAttributeIsRefusedWithTheNamesThereAre) {
    options_.attribute = "hat";
    try {
        draw(particles_at({{0, 0, 0}}, {0.5f}, {0}));
        FAIL() << "no error";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("P, pscale, heat"), std::string::npos) << e.what();
    }
}

TEST(Splats, ComponentsAndMagnitudesOfVectors) {
    PointSet points;
    points.count = 1;
    points.add("v", std::vector<Vec3f>{{3, -4, 12}});
    EXPECT_EQ(attribute_values(points, "v").at(0), 13);
    EXPECT_EQ(attribute_values(points, "v.y").at(0), -4);
    EXPECT_THROW(attribute_values(points, "v.w"), InputError);
}

}  // namespace
}  // namespace thixo::preview
