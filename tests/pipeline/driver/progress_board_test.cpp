#include "pipeline/driver/progress_board.h"

#include <gtest/gtest.h>

#include "pipeline/base/log.h"

namespace thixo {
namespace {

TEST(ProgressBoard, ReadsWhatAStageWrites) {
    testing::internal::CaptureStderr();
    Progress("render", 20, true).update(3, "64 samples");
    std::string line = testing::internal::GetCapturedStderr();
    line.pop_back();  // the newline
    const auto report = parse_progress(line);
    ASSERT_TRUE(report);
    EXPECT_EQ("render", report->stage);
    EXPECT_EQ(3, report->done);
    EXPECT_EQ(20, report->total);
    EXPECT_EQ("64 samples", report->note);
}

TEST(ProgressBoard, TakesNothingElseForProgress) {
    for (const char* line : {"", "@progress", "@progress sim", "@progress sim 1", "@progress sim x 3 n",
                             "@progress sim -1 3 n", "warning: @progress sim 1 2"})
        EXPECT_FALSE(parse_progress(line)) << line;
    EXPECT_TRUE(parse_progress("@progress sim 1 2"));
}

TEST(ProgressBoard, IsOnePlainLineAReportWhenPiped) {
    ProgressBoard board(false, false);
    EXPECT_EQ("sim 0/10  start\n", board.update({"sim", 0, 10, "start"}, 100));
    EXPECT_EQ("sim 1/10  12 steps  1:30 left\n", board.update({"sim", 1, 10, "12 steps"}, 110));
    EXPECT_EQ("", board.interrupt());
}

TEST(ProgressBoard, TheTimeLeftIsThatOfTheSlowestStage) {
    ProgressBoard board(false, false);
    board.update({"sim", 0, 10, ""}, 0);
    board.update({"render", 0, 10, ""}, 0);
    board.update({"sim", 5, 10, ""}, 10);                                              // 2 s a frame, 10 s left
    EXPECT_EQ("render 2/10    0:40 left\n", board.update({"render", 2, 10, ""}, 10));  // 5 s a frame, 8 to go
}

TEST(ProgressBoard, FramesOfAnEarlierRunDoNotCount) {
    ProgressBoard board(false, false);
    board.update({"sim", 90, 100, ""}, 0);
    EXPECT_EQ("sim 91/100    1:30 left\n", board.update({"sim", 91, 100, ""}, 10));
}

TEST(ProgressBoard, OneBarShowsAllStagesOnATerminal) {
    ProgressBoard board(true, false);
    board.update({"sim", 24, 48, ""}, 0);
    const std::string text = board.update({"render", 12, 48, "note"}, 1);
    EXPECT_EQ("\r\033[K[######..................] sim 24/48, render 12/48  note", text);
    EXPECT_EQ("\n", board.interrupt());  // a message starts on a new line
    EXPECT_EQ("", board.interrupt());
}

TEST(ProgressBoard, IsSilentWhenQuiet) {
    ProgressBoard board(true, true);
    EXPECT_EQ("", board.update({"sim", 1, 2, ""}, 0));
    EXPECT_EQ("", board.interrupt());
}

}  // namespace
}  // namespace thixo
