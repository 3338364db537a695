#include "pipeline/base/log.h"

#include <gtest/gtest.h>

#include <regex>

namespace thixo {
namespace {

// Under the test's capture stderr is a file, so it is never a terminal here.
template <class F>
std::string said(F&& f) {
    testing::internal::CaptureStderr();
    f();
    return testing::internal::GetCapturedStderr();
}

TEST(Log, QuietKeepsWarnings) {
    set_quiet(true);
    EXPECT_EQ("warning: two\n", said([] {
                  log_info("one");
                  log_warning("two");
              }));
    set_quiet(false);
    EXPECT_EQ("one 1\n", said([] { log_info("one {}", 1); }));
}

TEST(Progress, IsOnePlainLineAFrameWhenPiped) {
    const std::string text = said([] {
        Progress progress("sim", 20);
        progress.update(1, "12 steps");
        progress.update(2, "13 steps");
        progress.finish();
    });
    EXPECT_TRUE(std::regex_match(
        text, std::regex("sim 1/20  12 steps  \\d+:\\d\\d left\nsim 2/20  13 steps  \\d+:\\d\\d left\n")))
        << text;
}

TEST(Progress, SpeaksToTheDriverInItsOwnLines) {
    EXPECT_EQ("@progress render 3 20 64 samples\n", said([] {
                  Progress progress("render", 20, true);
                  progress.update(3, "64 samples");
                  progress.finish();
              }));
}

TEST(Progress, IsSilentWhenQuiet) {
    set_quiet(true);
    EXPECT_EQ("", said([] {
                  Progress progress("sim", 2);
                  progress.update(1, "");
                  progress.finish();
              }));
    set_quiet(false);
}

TEST(Progress, CountsOnlyTheFramesMadeNowForTheTimeLeft) {
    // A continued run starts at 90 of 100: after no time at all, no time is left, whatever the frames made earlier
    // cost.
    const std::string text = said([] { Progress("sim", 100).update(90, "x"); });
    EXPECT_EQ("sim 90/100  x  0:00 left\n", text);
}

}  // namespace
}  // namespace thixo
