// Checks of output folders: the caches, and the pictures beside them.
#include <gtest/gtest.h>

#include "pipeline/check/check.h"
#include "pipeline/contract/image.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;

class OutputCheck : public ::testing::Test {
  protected:
    void SetUp() override {
        for (const char* side : {"a", "b"}) {
            test::write_sample_cache(folder_ / side, 2);
            for (const char* look : {"frames", "frames.night"})
                for (int n = 1; n <= 2; ++n) write(side, look, n, 0.5f);
        }
        args_.path = (folder_ / "a").string();
        args_.against = (folder_ / "b").string();
    }
    void write(const std::string& side, const std::string& look, int n, float value) const {
        Image image(3, 2);
        for (const char* name : {"R", "G", "B"}) image.add(name, false).assign(6, value);
        make_folder(folder_ / side / look);
        write_exr(folder_ / side / look / fmt::format("beauty.{:04d}.exr", n), image);
    }
    std::vector<std::string> failing() const {
        std::vector<std::string> names;
        for (const FrameReport& f : check(args_).frames)
            if (!f.same()) names.push_back(f.name);
        return names;
    }
    TemporaryFolder folder_;
    CheckArgs args_;
};

TEST_F(OutputCheck, EqualCachesAndPicturesAgree) {
    const CheckReport report = check(args_);
    EXPECT_EQ(exit_code_of(report), kDone);
    EXPECT_EQ(report.frames.size(), 2u + 4u);
    EXPECT_NE(print_text(report).find("frames and pictures agree"), std::string::npos);
}

TEST_F(OutputCheck, APictureOfAnyLookThatDiffersByAPercentFails) {
    write("a", "frames", 2, 0.505f);
    EXPECT_EQ(failing(), (std::vector<std::string>{"frames/beauty.0002.exr"}));
    write("a", "frames.night", 1, 0.505f);
    EXPECT_EQ(failing(), (std::vector<std::string>{"frames/beauty.0002.exr", "frames.night/beauty.0001.exr"}));
    EXPECT_EQ(exit_code_of(check(args_)), kDifferent);
}

TEST_F(OutputCheck, APictureThatIsMissingFails) {
    fs::remove(folder_ / "a/frames/beauty.0001.exr");
    EXPECT_EQ(failing(), (std::vector<std::string>{"frames/beauty.0001.exr"}));
}

TEST_F(OutputCheck, PicturesMayDifferByAsMuchAsIsAllowed) {
    write("a", "frames", 2, 0.505f);  // relMSE 0.005^2/(0.25 + 0.01) = 1e-4
    args_.max_rel_mse = 2e-4;
    EXPECT_EQ(failing(), std::vector<std::string>());
    args_.max_rel_mse = 5e-5;
    EXPECT_EQ(failing(), (std::vector<std::string>{"frames/beauty.0002.exr"}));
}

TEST_F(OutputCheck, WhatOneSideAloneHasRenderedIsTold) {
    fs::remove_all(folder_ / "b/frames.night");
    const CheckReport report = check(args_);
    EXPECT_EQ(exit_code_of(report), kDone);
    EXPECT_NE(print_text(report).find("note, not compared: the pictures of frames.night/"), std::string::npos);
}

TEST_F(OutputCheck, OfTheCachesAloneLeavesPicturesOut) {
    write("a", "frames", 2, 0.505f);
    args_.path += "/cache";
    args_.against += "/cache";
    EXPECT_EQ(exit_code_of(check(args_)), kDone);
}

TEST_F(OutputCheck, AnUpdateTakesThePicturesToo) {
    write("a", "frames.night", 2, 0.7f);
    args_.update = true;
    EXPECT_EQ(check(args_).update.replaced, (std::vector<std::string>{"frames.night/beauty.0002.exr"}));
    args_.update = false;
    EXPECT_EQ(exit_code_of(check(args_)), kDone);
}

}  // namespace
}  // namespace thixo
