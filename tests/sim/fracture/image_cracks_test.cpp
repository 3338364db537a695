// Cracks painted by pictures, which the tests draw.
#include "sim/fracture/image_cracks.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/scene_io.h"
#include "sim/fracture/image_lines.h"
#include "tests/sim/fracture/bars.h"

namespace thixo {
namespace {

constexpr int kWidth = 120, kHeight = 30;  // pixels, of a bar of 120 x 30 mm: one is a millimetre

/// A picture that is dark where `of(x, y)` [mm, from the lower left corner] says so.
template <class F>
LineMask mask_of(int width, int height, F&& of) {
    LineMask mask{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) mask.dark.push_back(of(x + 0.5, height - y - 0.5) ? 1 : 0);
    return mask;
}

class Pictures : public testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    template <class F>
    std::string draw(F&& of) const {
        const LineMask mask = mask_of(kWidth, kHeight, of);
        Image8 picture{kWidth, kHeight, 3, {}};
        for (const std::uint8_t dark : mask.dark)
            for (int c = 0; c < 3; ++c) picture.values.push_back(dark ? 20 : 230);
        write_png(folder_ / "lines.png", picture);
        return (folder_ / "lines.png").string();
    }
    std::filesystem::path folder_;
};

/// A picture as large as the top of the bar, a centimetre above it.
scene::CrackImage above_the_bar(const std::string& file) {
    return {.file = file, .content = "", .origin = {-0.06, -0.015, 0.025}, .across = {0.12, 0, 0}, .up = {0, 0.03, 0}};
}

scene::Scene bar(const scene::CrackImage& image, double depth = 0.01) {
    scene::Scene s = fixture::breakable_bar(8e3);
    s.bodies[0].cracks = {{.points = {}, .image = image, .depth = depth}};
    return s;
}

TEST(ImageLines, AStrokeIsOneLineThroughItsMiddle) {
    const auto lines = trace_lines(
        thinned(mask_of(60, 40, [](double x, double y) { return std::abs(y - 20) < 3 && x > 10 && x < 50; })), 5);
    ASSERT_EQ(lines.size(), 1u);
    for (const Vec2d& at : lines[0]) EXPECT_NEAR(at.y(), 20, 1);
    // Thinning takes about half of the width off at either end.
    EXPECT_NEAR((lines[0].front() - lines[0].back()).norm(), 40, 2 * 3 + 1);
    EXPECT_EQ(simplified(lines[0], 1).size(), 2u);
}

TEST(ImageLines, ACrossHasFourBranchesThatMeet) {
    const auto lines = trace_lines(
        thinned(mask_of(60, 60, [](double x, double y) { return std::abs(y - 30) < 2 || std::abs(x - 30) < 2; })), 5);
    ASSERT_EQ(lines.size(), 4u);
    for (const PixelLine& line : lines) {
        const bool first = (line.front() - Vec2d(30, 30)).norm() < (line.back() - Vec2d(30, 30)).norm();
        EXPECT_LT(((first ? line.front() : line.back()) - Vec2d(30, 30)).norm(), 2);
        EXPECT_GT(((first ? line.back() : line.front()) - Vec2d(30, 30)).norm(), 26);
        EXPECT_EQ(first ? line.front() : line.back(), lines[0].front()) << "they meet at one place";
    }
}

TEST(ImageLines, ACircleIsARing) {
    const auto lines = trace_lines(
        thinned(mask_of(60, 60, [](double x, double y) { return std::abs(std::hypot(x - 30, y - 30) - 20) < 2; })), 5);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].front(), lines[0].back());
    for (const Vec2d& at : lines[0]) EXPECT_NEAR((at - Vec2d(30, 30)).norm(), 20, 1.5);
    double length = 0;
    const PixelLine ring = simplified(lines[0], 0.5);
    for (std::size_t k = 1; k < ring.size(); ++k) length += (ring[k] - ring[k - 1]).norm();
    EXPECT_NEAR(length, 2 * kPi * 20, 0.05 * 2 * kPi * 20);
}

TEST(ImageLines, ThinLinesStayAsTheyAre) {
    // A slanting line of single pixels, in stairs: thinned, it is as long.
    const LineMask drawn = mask_of(40, 40, [](double x, double y) { return std::abs(y - x) < 0.7; });
    const auto lines = trace_lines(thinned(drawn), 3);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_NEAR((lines[0].front() - lines[0].back()).norm(), 39 * std::sqrt(2.0), 3);
}

TEST_F(Pictures, OfAStrokeCutTheBodyBelowIt) {
    const scene::CrackImage image =
        above_the_bar(draw([](double x, double y) { return std::abs(x - 70) < 1.5 && y > 5 && y < 25; }));
    const Simulation s = make_simulation(bar(image));
    const Breaking& breaking = s.solids.breaking[0];
    ASSERT_EQ(s.solids.cracks.cracks.size(), 1u);
    // At x = 10 mm, from y = -10 to 10 mm, and from the top at 15 mm down to 5 mm. A pixel is a millimetre.
    Vec3d low(1, 1, 1), high(-1, -1, -1);
    for (const Vec3& v : s.solids.cracks.vertex) {
        const Vec3d x = (v + breaking.origin).cast<double>();
        low = low.cwiseMin(x), high = high.cwiseMax(x);
    }
    EXPECT_NEAR(low.x(), 0.01, 1e-3);
    EXPECT_NEAR(high.x(), 0.01, 1e-3);
    EXPECT_NEAR(low.y(), -0.01, 2.5e-3);  // half of the stroke's width, and a pixel
    EXPECT_NEAR(high.y(), 0.01, 2.5e-3);
    EXPECT_NEAR(low.z(), 0.005, 0.1 * static_cast<double>(breaking.row));
}

TEST_F(Pictures, OfARingHaveAClosedFront) {
    const scene::CrackImage image =
        above_the_bar(draw([](double x, double y) { return std::abs(std::hypot(x - 60, y - 15) - 10) < 1.2; }));
    const Simulation s = make_simulation(bar(image, 0.004));
    ASSERT_EQ(s.solids.cracks.fronts.size(), 1u);
    EXPECT_EQ(s.solids.cracks.fronts[0].closed, 1);
    for (const CrackNode& node : s.solids.cracks.fronts[0].nodes)
        EXPECT_NEAR((node.place + s.solids.breaking[0].origin).head<2>().norm(), 0.01, 1.5e-3);
}

TEST_F(Pictures, OfACrossCutInBothDirections) {
    const scene::CrackImage image = above_the_bar(draw([](double x, double y) {
        return (std::abs(x - 60) < 1.2 && y > 3 && y < 27) || (std::abs(y - 15) < 1.2 && x > 40 && x < 80);
    }));
    const Simulation s = make_simulation(bar(image, 0.008));
    EXPECT_EQ(s.solids.cracks.cracks.size(), 4u);
    // Half as deep as the cut, bonds across either plane are parted, but near the ends and the middle.
    const Elements& e = s.solids.elements;
    std::size_t cut = 0, left = 0;
    for (Index i = 0; i < e.size(); ++i)
        for (std::size_t k = e.bonds.begin[i]; k < e.bonds.begin[i + 1]; ++k) {
            const Vec3d a = (xyz(e.rest[i]) + s.solids.breaking[0].origin).cast<double>(),
                        b = (xyz(e.rest[e.bonds.neighbour[k]]) + s.solids.breaking[0].origin).cast<double>();
            if (std::min(a.z(), b.z()) < 0.013 || !(a.y() < 0 && b.y() > 0)) continue;
            const double x = (a.x() + b.x()) / 2;
            if (std::abs(x) > 0.015) continue;
            (e.bonds.visibility[k] < 0.5 ? cut : left) += 1;
        }
    EXPECT_GT(cut, 10u);
    EXPECT_LT(left, cut / 4);
}

TEST_F(Pictures, AreSeenFromWhereTheyHang) {
    // The picture hangs at the end of the bar and looks along x: the stroke is cut into the end.
    scene::CrackImage image =
        above_the_bar(draw([](double x, double) { return std::abs(x - 60) < 2; }));  // from edge to edge
    image.origin = {0.07, -0.06, -0.015};
    image.across = {0, 0.12, 0};
    image.up = {0, 0, 0.03};
    const Simulation s = make_simulation(bar(image));
    ASSERT_EQ(s.solids.cracks.cracks.size(), 1u);
    double deepest = 1;
    for (const Vec3& v : s.solids.cracks.vertex) {
        const Vec3d x = (v + s.solids.breaking[0].origin).cast<double>();
        EXPECT_NEAR(x.y(), 0, 1.5e-3);
        deepest = std::min(deepest, x.x());
    }
    EXPECT_NEAR(deepest, 0.05, 1e-3);
}

std::string problem_of(const scene::Scene& scene) {
    try {
        make_simulation(scene);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST_F(Pictures, ThatCannotBePaintedAreRefused) {
    const auto says = [](const scene::Scene& scene, const std::string& words) {
        const std::string problem = problem_of(scene);
        EXPECT_NE(problem.find("bodies.bar.cracks.0"), std::string::npos) << problem;
        EXPECT_NE(problem.find(words), std::string::npos) << problem;
    };
    const std::string blank = draw([](double, double) { return false; });
    says(bar(above_the_bar(blank)), "shows no line");
    const std::string stroke = draw([](double x, double) { return std::abs(x - 60) < 2; });
    scene::CrackImage aside = above_the_bar(stroke);
    aside.origin.x() += 0.2;
    says(bar(aside), "misses the body");
    scene::CrackImage within = above_the_bar(stroke);
    within.origin.z() = 0;
    says(bar(within), "stands within the body");
    std::ofstream(stroke, std::ios::binary | std::ios::in).seekp(60) << "damage";
    says(bar(above_the_bar(stroke)), "is damaged");
    says(bar(above_the_bar((folder_ / "none.png").string())), "none.png");
}

TEST_F(Pictures, AreNamedByTheirPlaceInTheScene) {
    const auto text = [&](const std::string& image) {
        return fmt::format(
            "scene: {{name: bar}}\nmaterials:\n  stone: {{youngs_modulus: 1e6, fracture: {{strength: 1e4}}}}\nbodies:\n"
            "  bar:\n    material: stone\n    shape: {{box: {{size: [0.12, 0.03, 0.03]}}}}\n    cracks:\n"
            "      - {{depth: 0.01, {}}}\nsolver: {{spacing: 0.006}}\n",
            image);
    };
    const auto problem = [&](const std::string& image) -> std::string {
        try {
            scene::parse_scene(text(image), (folder_ / "scene.yaml").string());
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_NE(problem("image: {file: none.png}").find("scene.yaml:9:"), std::string::npos);
    EXPECT_NE(problem("image: {file: none.png}").find("there is no image file"), std::string::npos);
    std::ofstream(folder_ / "bad.png") << "no picture";
    EXPECT_NE(problem("image: {file: bad.png}").find("scene.yaml:9:"), std::string::npos);
    EXPECT_NE(problem("image: {file: bad.png}").find("damaged"), std::string::npos);
    draw([](double x, double) { return std::abs(x - 60) < 2; });
    EXPECT_EQ(
        problem("image: {file: lines.png, origin: [-0.06, -0.015, 0.02], across: [0.12, 0, 0], up: [0, 0.03, 0]}"), "");
    EXPECT_NE(problem("image: {file: lines.png, across: [1, 0, 0], up: [2, 0, 0]}").find("span no picture"),
              std::string::npos);
    EXPECT_NE(problem("image: {file: lines.png}, points: [{at: [0, 0, 0]}, {at: [0, 1, 0]}]").find("by an \"image\""),
              std::string::npos);
    EXPECT_NE(problem("strength: 1").find("a line has at least two points"), std::string::npos);
}

}  // namespace
}  // namespace thixo
