// The preview stage: from a cache to pictures.
#include <gtest/gtest.h>

#include "pipeline/contract/image.h"
#include "pipeline/contract/stage_args.h"
#include "pipeline/geometry/mesh_io.h"
#include "render/preview/preview.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo {
namespace {

namespace fs = std::filesystem;

class PreviewStage : public ::testing::Test {
  protected:
    void SetUp() override {
        CacheWriter writer = CacheWriter::create(folder_.path(), test::sample_identity());
        TriangleMesh mesh;
        mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
        const std::string asset = writer.add_asset(write_ply(mesh));
        for (int n = 1; n <= 3; ++n) {
            Frame frame = test::sample_frame(n, 300, 0);
            frame.particles.add("pscale", std::vector<float>(300, 0.05f));
            frame.obstacles[0].asset = asset;
            writer.write_frame(frame);
        }
        writer.finish();
        args_.out = folder_.path().string();
        args_.preview = args_.quiet = true;
        scene_.look.output.width = 96;
        scene_.look.output.height = 54;
    }
    std::vector<std::string> pictures() const {
        std::vector<std::string> names;
        for (const auto& [name, bytes] : test::contents(folder_ / "preview")) names.push_back(name);
        return names;
    }
    test::TemporaryFolder folder_;
    RenderArgs args_;
    scene::Scene scene_;
};

TEST_F(PreviewStage, DrawsEveryFrameUnderItsName) {
    args_.attribute = "temperature";
    EXPECT_EQ(run_preview(args_, scene_), kDone);
    EXPECT_EQ(pictures(), (std::vector<std::string>{"particles.temperature.0001.png", "particles.temperature.0002.png",
                                                    "particles.temperature.0003.png"}));
    const Image8 picture = read_png(folder_ / "preview" / "particles.temperature.0002.png");
    EXPECT_EQ(picture.width, 96);
    EXPECT_EQ(picture.height, 54);
}

TEST_F(PreviewStage, ABodyWearsItsOwnLook) {
    args_.frames = "1";
    const auto drawn = [&](const std::string& body, const std::string& material) {
        scene_.bodies.resize(1);
        scene_.bodies[0].name = "pour";
        scene_.bodies[0].look = body;
        scene_.materials.resize(1);
        scene_.materials[0].name = "water";
        scene_.materials[0].look = material;
        run_preview(args_, scene_);
        return read_png(folder_ / "preview" / "particles.material.0001.png").values;
    };
    scene::Appearance red, blue;
    red.name = "red", red.colour = {0.8, 0, 0};
    blue.name = "blue", blue.colour = {0, 0, 0.8};
    scene_.look.appearances = {red, blue};
    const auto plain = drawn("", "blue");
    EXPECT_EQ(drawn("", "red"), drawn("red", "red"));
    EXPECT_NE(plain, drawn("", "red"));
    EXPECT_NE(plain, drawn("red", "blue"));
}

TEST_F(PreviewStage, FarFromTheOriginIsDrawnAsNearIt) {
    const auto drawn = [&](const Vec3d& away) {
        const test::TemporaryFolder folder;
        CacheWriter writer = CacheWriter::create(folder.path(), test::sample_identity());
        Frame frame = test::sample_frame(1, 300, 0);
        frame.particles.add("pscale", std::vector<float>(300, 0.05f));
        frame.particles.origin = frame.surfels.origin = away;
        writer.write_frame(frame);
        writer.finish();
        scene::Scene scene;
        scene.look.output.width = 96;
        scene.look.output.height = 54;
        scene.look.camera.position = away + Vec3d(0, -4, 1);
        scene.look.camera.look_at = away;
        args_.out = folder.path().string();
        run_preview(args_, scene);
        return read_png(folder / "preview/particles.material.0001.png").values;
    };
    // A whole number of metres: the places relative to the camera are the same bits.
    EXPECT_EQ(drawn({0, 0, 0}), drawn({1e6, -4e4, 3e3}));
}

TEST_F(PreviewStage, DrawsOnlyTheFramesAskedForAndReportsMissingOnes) {
    args_.frames = "2,7";
    EXPECT_NE(test::message_of([&] { run_preview(args_, scene_); }, kBadCache), "");
    EXPECT_EQ(pictures(), std::vector<std::string>{"particles.material.0002.png"});
}

TEST_F(PreviewStage, GivesTheSameBytesAgain) {
    args_.attribute = "v";
    run_preview(args_, scene_);
    const auto first = test::contents(folder_ / "preview");
    run_preview(args_, scene_);
    EXPECT_EQ(test::contents(folder_ / "preview"), first);
}

TEST_F(PreviewStage, FitsTheViewWhereTheCameraSeesNothing) {
    scene_.look.camera.position = {0, -3, 100};
    scene_.look.camera.look_at = {0, -3, 200};
    scene_.look.camera.up = {0, 1, 0};
    args_.frames = "1";
    run_preview(args_, scene_);
    const Image8 picture = read_png(folder_ / "preview" / "particles.material.0001.png");
    std::size_t dark = 0;  // particles are darker than any background
    for (std::size_t i = 0; i < picture.values.size(); i += 3) dark += picture.values[i] < 190;
    EXPECT_GT(dark, 50u);
}

TEST_F(PreviewStage, RefusesFollow) {
    args_.follow = true;
    EXPECT_NE(test::message_of([&] { run_preview(args_, scene_); }, kBadInput), "");
}

}  // namespace
}  // namespace thixo
