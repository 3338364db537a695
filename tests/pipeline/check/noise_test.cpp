// Checks of pictures that hold noise: what differs in noise alone passes, and what differs in more is found.
#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/check/check.h"
#include "pipeline/check/compare_noisy.h"
#include "pipeline/check/compare_pictures.h"
#include "pipeline/check/flip.h"
#include "pipeline/check/report_files.h"
#include "pipeline/check/welch.h"
#include "pipeline/contract/image.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;

struct Sampled {
    int width = 96, height = 54, samples = 8;
};

/// A picture as a path tracer makes it. Each pixel is the mean of samples whose spread is as large as the mean. The
/// variance pass tells that spread. Colours are stored as half.
Image rendered(std::uint64_t seed, const Sampled& size, double brightness = 1) {
    Image image(size.width, size.height);
    std::uint64_t colour = 0;
    for (const std::string name : {"R", "G", "B"}) {
        auto& mean = image.add(name, true);
        std::vector<float> variance(mean.size());
        for (std::size_t i = 0; i < mean.size(); ++i) {
            const double light = brightness * (0.1 + 0.5 * double(i) / double(mean.size()));
            double sum = 0, squares = 0;
            for (int k = 0; k < size.samples; ++k) {
                const double x = -light * std::log1p(-random_unit(seed, i, std::uint64_t(k), colour));
                sum += x;
                squares += x * x;
            }
            const double n = size.samples;
            mean[i] = static_cast<float>(sum / n);
            variance[i] = static_cast<float>((squares / n - sum * sum / (n * n)) / (n - 1));
        }
        ++colour;
        image.add("variance." + name, false) = variance;
    }
    image.add("samples", false).assign(image.pixels(), static_cast<float>(size.samples));
    image.add("Z", false).assign(image.pixels(), 2);
    return decode_exr(encode_exr(image), "picture");
}

std::vector<std::string> noise_problems(const Image& a, const Image& b) {
    std::vector<std::string> problems;
    compare_noisy(a, b, kFalseAlarms, problems);
    return problems;
}

TEST(StudentTail, IsThatOfTheTables) {
    // Two-sided 5 % and 1 % points (any table of Student's t).
    EXPECT_NEAR(student_tail(12.706, 1), 0.05, 1e-5);
    EXPECT_NEAR(student_tail(2.228, 10), 0.05, 1e-4);
    EXPECT_NEAR(student_tail(3.169, 10), 0.01, 1e-4);
    EXPECT_NEAR(student_tail(1.980, 120), 0.05, 1e-4);
    EXPECT_NEAR(student_tail(1.960, 1e7), 0.05, 1e-4);
    EXPECT_EQ(student_tail(0, 5), 1);
    EXPECT_NEAR(student_tail(-2.228, 10), student_tail(2.228, 10), 1e-12);
    EXPECT_NEAR(student_tail(4, 9e4), student_tail(4, 1.1e5), 1e-7);
}

TEST(NoiseCheck, PicturesThatDifferInTheirSeedAlonePass) {
    int alarms = 0;
    for (std::uint64_t k = 0; k < 100; ++k)
        alarms += !noise_problems(rendered(2 * k, {}), rendered(2 * k + 1, {})).empty();
    EXPECT_LE(alarms, 1);
}

TEST(NoiseCheck, ABrightnessShiftOfHalfAPercentIsFound) {
    const Sampled size{480, 270, 16};
    const Image b = rendered(1, size);
    EXPECT_TRUE(noise_problems(rendered(2, size), b).empty());
    for (const double brightness : {1.005, 0.995})
        EXPECT_FALSE(noise_problems(rendered(2, size, brightness), b).empty());
}

TEST(NoiseCheck, OfDenoisedPicturesTheColoursBeforeAreCompared) {
    // Denoised colours differ by more than the variance allows here, the noisy ones by their seed alone.
    const auto denoised = [](std::uint64_t seed, float clean) {
        Image image = rendered(seed, {});
        for (const std::string name : {"R", "G", "B"}) {
            const std::vector<float> noisy = image.get(name);
            image.add("noisy." + name) = noisy;
            image.find(name)->values.assign(image.pixels(), clean);
        }
        return image;
    };
    EXPECT_TRUE(noise_problems(denoised(1, 0.4f), denoised(2, 0.2f)).empty());
}

TEST(NoiseCheck, AChangeInATileIsFoundAndItsPlaceIsTold) {
    Image a = rendered(1, {});
    const Image b = rendered(2, {});
    for (int y = 32; y < 48; ++y)
        for (int x = 64; x < 80; ++x) a.find("G")->values[std::size_t(y * a.width + x)] *= 1.5f;
    const std::vector<std::string> problems = noise_problems(a, b);
    ASSERT_FALSE(problems.empty());
    EXPECT_NE(problems.back().find("G of a tile at (64, 32)"), std::string::npos) << problems.back();
}

TEST(NoiseCheck, WhereThereIsNoNoiseASmallDifferenceIsOne) {
    const auto flat = [](float value) {
        Image image(20, 20);
        for (const std::string name : {"R", "G", "B"}) {
            image.add(name, false).assign(400, value);
            image.add("variance." + name, false);
        }
        image.add("samples", false).assign(400, 4);
        return image;
    };
    EXPECT_TRUE(noise_problems(flat(0.5f), flat(0.5f)).empty());
    EXPECT_FALSE(noise_problems(flat(0.5f), flat(std::nextafter(0.5f, 1.0f))).empty());
}

TEST(NoiseCheck, PicturesWhoseNoiseIsUnknownFail) {
    Image a = rendered(1, {});
    std::erase_if(a.channels, [](const ImageChannel& c) { return c.name == "variance.G"; });
    EXPECT_NE(noise_problems(a, rendered(1, {})).at(0).find("noise of G is not known"), std::string::npos);
    Image once = rendered(1, {});
    once.find("samples")->values[7] = 1;
    EXPECT_EQ(noise_problems(once, rendered(1, {})).size(), 3u);
}

TEST(Flip, IsZeroForEqualPicturesAndOneForGreenAgainstBlue) {
    const auto flat = [](float r, float g, float b) {
        Image image(8, 6);
        image.add("R", false).assign(48, r);
        image.add("G", false).assign(48, g);
        image.add("B", false).assign(48, b);
        return image;
    };
    EXPECT_EQ(mean_flip(flat(0.2f, 0.4f, 0.6f), flat(0.2f, 0.4f, 0.6f)), 0);
    EXPECT_NEAR(mean_flip(flat(0, 1, 0), flat(0, 0, 1)), 1, 1e-3);  // the largest error there is, by definition
    // Black and white: (100^0.7 - t)/(m - t) of the last twentieth, with m = 41.3 for green and blue and t = 0.4 m.
    EXPECT_NEAR(mean_flip(flat(0, 0, 0), flat(1, 1, 1)), 0.967, 0.002);
    EXPECT_LT(mean_flip(flat(0.5f, 0.5f, 0.5f), flat(0.51f, 0.5f, 0.5f)),
              mean_flip(flat(0.5f, 0.5f, 0.5f), flat(0.6f, 0.5f, 0.5f)));
}

TEST(Flip, AnEdgeThatMovedCountsMoreThanTheSameColoursApart) {
    Image a(64, 64), b(64, 64);
    for (const char* name : {"R", "G", "B"}) {
        auto &left = a.add(name, false), &right = b.add(name, false);
        for (std::size_t i = 0; i < left.size(); ++i) {
            left[i] = i % 64 < 32 ? 0.2f : 0.5f;
            right[i] = i % 64 < 36 ? 0.2f : 0.5f;
        }
    }
    const std::vector<float> map = flip_map(a, b);
    EXPECT_GT(map[32 * 64 + 34], map[32 * 64 + 20]);
    EXPECT_GT(map[32 * 64 + 34], 0.2f);
    EXPECT_LT(map[32 * 64 + 4], 1e-4f);
}

class SequenceCheck : public testing::Test {
  protected:
    SequenceCheck() {
        args_.path = (folder_ / "a").string();
        args_.against = (folder_ / "b").string();
        for (int n = 1; n <= 4; ++n) {
            write("a", n, frame(n));
            write("b", n, frame(n));
        }
    }
    static Image frame(int n) { return rendered(std::uint64_t(n), {48, 32, 4}); }
    void write(const char* side, int n, const Image& image) const {
        make_folder(folder_ / side);
        write_exr(folder_ / side / fmt::format("beauty.{:04}.exr", n), image);
    }
    TemporaryFolder folder_;
    CheckArgs args_;
};

TEST_F(SequenceCheck, ASurfaceThatPopsIsTheFlicker) {
    Image popped = frame(3);
    for (std::size_t i = 200; i < 260; ++i) popped.find("R")->values[i] += 1;
    write("a", 3, popped);
    args_.max_flicker = 1e-3;
    const CheckReport report = check(args_);
    ASSERT_NE(report.most_flicker(), nullptr);
    const std::string& worst = report.most_flicker()->name;
    EXPECT_TRUE(worst == "beauty.0003.exr" || worst == "beauty.0004.exr") << worst;  // it comes, and goes
    EXPECT_EQ(report.frames[1].measures->flicker, 0);
    EXPECT_LT(report.frames[0].measures->flicker, 0);
    EXPECT_FALSE(report.frames[3].same()) << "its pixels are equal, and it flickers";
}

TEST_F(SequenceCheck, PassesWithoutNoiseAreComparedAlone) {
    args_.tier = "passes";
    write("a", 2, rendered(99, {48, 32, 4}));
    EXPECT_EQ(exit_code_of(check(args_)), kDone);
    Image moved = frame(2);
    moved.find("Z")->values[5] = std::nextafter(2.0f, 3.0f);
    write("a", 2, moved);
    EXPECT_EQ(exit_code_of(check(args_)), kDifferent);
}

TEST_F(SequenceCheck, AnotherSeedDiffersBitForBitAndPassesUpToNoise) {
    for (int n = 1; n <= 4; ++n) write("a", n, rendered(std::uint64_t(50 + n), {48, 32, 4}));
    EXPECT_EQ(exit_code_of(check(args_)), kDifferent);
    args_.tier = "noise";
    const CheckReport report = check(args_);
    EXPECT_EQ(exit_code_of(report), kDone) << print_text(report);
    Image broken = frame(2);
    broken.find("B")->values[9] = std::numeric_limits<float>::quiet_NaN();
    write("a", 2, broken);
    EXPECT_EQ(exit_code_of(check(args_)), kDifferent);
}

TEST_F(SequenceCheck, FlipHasALimitOfItsOwn) {
    args_.max_rel_mse = 1e6;
    for (int n = 1; n <= 4; ++n) write("a", n, rendered(std::uint64_t(50 + n), {48, 32, 4}));
    EXPECT_EQ(exit_code_of(check(args_)), kDone);
    args_.max_flip = 0.01;
    EXPECT_EQ(exit_code_of(check(args_)), kDifferent);
}

TEST_F(SequenceCheck, ItsReportsAreFiles) {
    Image changed = frame(2);
    changed.find("G")->values[3] += 0.5f;
    write("a", 2, changed);
    args_.html = (folder_ / "sheet").string();
    CheckReport report = check(args_);
    report.a = "<a> & \"b\"";
    const std::string page = print_html(report), junit = print_junit(report);
    EXPECT_TRUE(fs::exists(fs::path(args_.html) / report.frames[1].sheet_picture));
    EXPECT_NE(page.find("<img src=\"" + report.frames[1].sheet_picture + "\""), std::string::npos);
    EXPECT_EQ(page.find("<a>"), std::string::npos);
    EXPECT_NE(junit.find("tests=\"4\" failures=\"1\" errors=\"0\""), std::string::npos) << junit;
    EXPECT_NE(junit.find("name=\"beauty.0002.exr\"><failure message=\"1 pixels differ\"/>"), std::string::npos)
        << junit;
}

}  // namespace
}  // namespace thixo
