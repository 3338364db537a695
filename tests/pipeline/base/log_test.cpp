#include "pipeline/base/log.h"

#include <gtest/gtest.h>

#include <chrono>
#include <regex>
#include <thread>

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
        progress.update(0, "");
        progress.update(1, "12 steps");
        progress.finish();
    });
    EXPECT_TRUE(std::regex_match(text, std::regex("sim 0/20  \nsim 1/20  12 steps  \\d+:\\d\\d left\n"))) << text;
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
    // A continued run starts at 90 of 100; one frame of 0.2 s later nine are left: 2 s, whatever the frames made
    // earlier cost.
    const std::string text = said([] {
        Progress progress("sim", 100);
        progress.update(90, "x");
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        progress.update(91, "x");
    });
    EXPECT_EQ("sim 90/100  x\nsim 91/100  x  0:02 left\n",
              text);  // 1.5 to 2.5 s round to this: the sleep may take 80 ms more
}

TEST(Log, ClockTextIsShort) {
    EXPECT_EQ("0:07", clock_text(7.4));
    EXPECT_EQ("1:00", clock_text(59.6));
    EXPECT_EQ("12:34", clock_text(754));
    EXPECT_EQ("1:02:03", clock_text(3723));
}

}  // namespace
}  // namespace thixo
