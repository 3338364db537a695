// Checks of pictures: exact means exact, and every way to differ is told.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pipeline/check/check.h"
#include "pipeline/check/compare_pictures.h"
#include "pipeline/check/difference_picture.h"
#include "pipeline/contract/image.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo {
namespace {

using test::message_of;
using test::TemporaryFolder;
namespace fs = std::filesystem;

constexpr int kWidth = 31, kHeight = 17;  // odd, so that rows and columns cannot be mixed up unseen

Image sample_picture(int number) {
    Image image(kWidth, kHeight);
    for (const char* name : {"R", "G", "B", "Z"}) {
        auto& values = image.add(name, false);
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = static_cast<float>(
                0.1 + random_unit(static_cast<std::uint64_t>(number), i, 0, static_cast<std::uint64_t>(name[0])));
    }
    return image;
}

std::vector<float>& channel(Image& image, const char* name) { return image.find(name)->values; }

class PictureCheck : public ::testing::Test {
  protected:
    void SetUp() override {
        for (const char* side : {"a", "b"}) {
            make_folder(folder_ / side);
            for (int n = 1; n <= 3; ++n) write(side, n, sample_picture(n));
        }
        args_.path = (folder_ / "a").string();
        args_.against = (folder_ / "b").string();
    }
    fs::path file(const std::string& side, int n) const { return folder_ / side / fmt::format("beauty.{:04d}.exr", n); }
    void write(const std::string& side, int n, const Image& image) const { write_exr(file(side, n), image); }

    /// Expects that only frame 2 fails, with a problem that holds the words, and returns its report.
    FrameReport only_frame_2_fails(const std::string& words, ExitCode code = kDifferent) const {
        const CheckReport report = check(args_);
        EXPECT_EQ(exit_code_of(report), code);
        FrameReport second;
        for (const FrameReport& f : report.frames) {
            const bool is_second = f.name == "beauty.0002.exr";
            EXPECT_EQ(f.same(), !is_second) << f.name;
            if (is_second) second = f;
        }
        std::string problems;
        for (const std::string& p : second.problems) problems += p + "\n";
        EXPECT_NE(problems.find(words), std::string::npos) << problems;
        return second;
    }

    TemporaryFolder folder_;
    CheckArgs args_;
};

TEST_F(PictureCheck, PassesEqualFolders) {
    const CheckReport report = check(args_);
    EXPECT_EQ(report.frames.size(), 3u);
    EXPECT_EQ(exit_code_of(report), kDone);
    for (const FrameReport& f : report.frames) EXPECT_EQ(f.picture.pixels_different, 0u);
}

TEST_F(PictureCheck, FailsOnOneUlpInOnePixelAndNamesIt) {
    Image image = sample_picture(2);
    float& value = channel(image, "G")[7 * kWidth + 5];
    const float before = value;
    value = std::nextafter(value, 2.0f);
    write("a", 2, image);
    const FrameReport f = only_frame_2_fails("1 pixels differ");
    EXPECT_EQ(f.picture.pixels_different, 1u);
    EXPECT_EQ(f.picture.worst_x, 5);
    EXPECT_EQ(f.picture.worst_y, 7);
    EXPECT_EQ(f.picture.worst_channel, "G");
    EXPECT_EQ(f.picture.max_abs, static_cast<double>(value) - before);
}

TEST_F(PictureCheck, TellsMinusZeroFromZero) {
    Image a = sample_picture(2), b = sample_picture(2);
    channel(a, "R")[3] = -0.0f;
    channel(b, "R")[3] = 0.0f;
    write("a", 2, a);
    write("b", 2, b);
    EXPECT_EQ(only_frame_2_fails("1 pixels differ").picture.max_abs, 0.0);
}

TEST_F(PictureCheck, FailsOnAMissingFrame) {
    fs::remove(file("a", 2));
    only_frame_2_fails("is missing");
}

TEST_F(PictureCheck, FailsOnAnExtraFrame) {
    fs::remove(file("b", 2));
    only_frame_2_fails("is not in the reference");
}

TEST_F(PictureCheck, FailsOnAnotherSize) {
    Image image(kHeight, kWidth);  // as many pixels
    for (const ImageChannel& c : sample_picture(2).channels) image.add(c.name, false) = c.values;
    write("a", 2, image);
    only_frame_2_fails("17 x 31 pixels, the reference 31 x 17");
}

TEST_F(PictureCheck, FailsOnNaNEvenInBoth) {
    Image image = sample_picture(2);
    channel(image, "Z")[40] = std::numeric_limits<float>::quiet_NaN();
    write("a", 2, image);
    write("b", 2, image);
    const FrameReport f = only_frame_2_fails("1 values are not finite");
    EXPECT_EQ(f.picture.pixels_different, 0u);
}

TEST_F(PictureCheck, FailsOnInfinityUnderATolerance) {
    Image image = sample_picture(2);
    channel(image, "Z")[40] = std::numeric_limits<float>::infinity();
    write("a", 2, image);
    args_.max_rel_mse = 1e6;
    only_frame_2_fails("not finite");
}

TEST_F(PictureCheck, FailsOnARenamedChannel) {
    Image image = sample_picture(2);
    image.find("Z")->name = "Y";
    write("a", 2, image);
    only_frame_2_fails("channel Z is missing");
    only_frame_2_fails("channel Y is not in the reference");
}

TEST_F(PictureCheck, FailsOnAnotherStoredType) {
    // Values that half holds exactly: nothing but the type differs.
    Image a(4, 2), b(4, 2);
    a.add("R", true).assign(8, 0.5f);
    b.add("R", false).assign(8, 0.5f);
    write("a", 2, a);
    write("b", 2, b);
    only_frame_2_fails("channel R is stored as half, the reference as float");
}

TEST_F(PictureCheck, CallsATruncatedFileDamagedWhereverItIsCut) {
    const std::string whole = read_whole(file("a", 2));
    for (const double part : {0.0, 0.1, 0.5, 0.9, 0.999}) {
        write_whole(file("a", 2), whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
        EXPECT_TRUE(only_frame_2_fails("beauty.0002.exr", kBadCache).damaged) << part;
    }
}

TEST_F(PictureCheck, CallsADamagedExtraFrameDamaged) {
    fs::remove(file("b", 2));
    write_whole(file("a", 2), "no picture");
    EXPECT_TRUE(only_frame_2_fails("beauty.0002.exr", kBadCache).damaged);
}

TEST_F(PictureCheck, ComparesOnlyTheFramesAskedFor) {
    write_whole(file("a", 2), "damaged");
    args_.frames = "1-3x2";
    const CheckReport report = check(args_);
    EXPECT_EQ(report.frames.size(), 2u);
    EXPECT_EQ(exit_code_of(report), kDone);
    args_.frames = "9";
    EXPECT_NE(message_of([&] { check(args_); }, kBadCache), "");
}

TEST_F(PictureCheck, GivesTheErrorsThatTheirFormulasSay) {
    // a - b = 0.5 in one of four pixels of one channel, b = 1 everywhere: MSE = 0.25/4, relMSE = MSE/1.01, PSNR = 10
    // log10(1/MSE).
    Image a(2, 2), b(2, 2);
    a.add("R", false) = {1, 1, 1, 1.5f};
    b.add("R", false) = {1, 1, 1, 1};
    const PictureDifference d = compare_pictures("x", a, b, 0).picture;
    const double round_off = 1e-12;  // a handful of double operations
    EXPECT_NEAR(d.rel_mse, 0.0625 / 1.01, round_off);
    EXPECT_NEAR(d.psnr, 10 * std::log10(16.0), 10 * round_off);
    EXPECT_EQ(d.max_abs, 0.5);
}

TEST_F(PictureCheck, TolerancePassesBelowItsThresholdAndFailsAbove) {
    Image image = sample_picture(2);
    for (float& x : channel(image, "R")) x += 0.01f;
    write("a", 2, image);
    args_.max_rel_mse = 1e6;
    const CheckReport report = check(args_);
    EXPECT_EQ(exit_code_of(report), kDone);
    const double rel_mse = report.frames[1].picture.rel_mse;
    EXPECT_GT(rel_mse, 0);
    args_.max_rel_mse = 1.001 * rel_mse;
    EXPECT_EQ(exit_code_of(check(args_)), kDone);
    args_.max_rel_mse = 0.999 * rel_mse;
    only_frame_2_fails("relMSE");
}

TEST_F(PictureCheck, UpdateMakesTheReferenceEqualAndSaysWhatItDid) {
    Image image = sample_picture(2);
    channel(image, "R")[0] += 1;
    write("a", 2, image);
    write("a", 4, sample_picture(4));
    fs::remove(file("a", 3));
    args_.update = true;
    const CheckReport report = check(args_);
    EXPECT_EQ(exit_code_of(report), kDone);
    EXPECT_EQ(report.update.replaced, std::vector<std::string>{"beauty.0002.exr"});
    EXPECT_EQ(report.update.added, std::vector<std::string>{"beauty.0004.exr"});
    EXPECT_EQ(report.update.removed, std::vector<std::string>{"beauty.0003.exr"});
    args_.update = false;
    EXPECT_EQ(exit_code_of(check(args_)), kDone);
    EXPECT_EQ(test::contents(folder_ / "a"), test::contents(folder_ / "b"));
}

TEST_F(PictureCheck, UpdateMakesAReferenceThatWasNotThere) {
    args_.against = (folder_ / "new" / "reference").string();
    args_.update = true;
    check(args_);
    EXPECT_EQ(test::contents(folder_ / "a"), test::contents(args_.against));
}

TEST_F(PictureCheck, UpdateNeverTakesADamagedOrNaNPicture) {
    args_.update = true;
    const auto before = test::contents(folder_ / "b");
    Image image = sample_picture(2);
    channel(image, "Z")[40] = std::numeric_limits<float>::quiet_NaN();
    write("a", 2, image);
    EXPECT_NE(message_of([&] { check(args_); }, kBadCache), "");
    write_whole(file("a", 2), "damaged");
    EXPECT_NE(message_of([&] { check(args_); }, kBadCache), "");
    EXPECT_EQ(test::contents(folder_ / "b"), before);
}

TEST_F(PictureCheck, DrawsTheDifferenceWhereItIs) {
    Image image = sample_picture(2);
    channel(image, "G")[7 * kWidth + 5] += 0.25f;
    channel(image, "G")[3 * kWidth + 9] = std::nextafter(channel(image, "G")[3 * kWidth + 9], 2.0f);
    write("a", 2, image);
    args_.diff = (folder_ / "diff").string();
    check(args_);
    const Image8 picture = read_png(folder_ / "diff" / "beauty.0002.diff.png");
    ASSERT_EQ(picture.width, 3 * kWidth);
    ASSERT_EQ(picture.height, kHeight);
    const auto heat = [&](int x, int y, int k) {
        return int(
            picture.values[static_cast<std::size_t>(picture.channels * (y * picture.width + 2 * kWidth + x) + k)]);
    };
    EXPECT_EQ(heat(5, 7, 2), 255);  // the largest difference is white
    EXPECT_GT(heat(9, 3, 0), 60);   // one ulp is still seen
    EXPECT_EQ(heat(4, 7, 0), 0);    // equal pixels are black
    EXPECT_EQ(test::contents(folder_ / "diff").size(), 1u);
}

}  // namespace
}  // namespace thixo
