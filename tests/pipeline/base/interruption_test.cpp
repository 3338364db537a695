#include "pipeline/base/interruption.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "pipeline/base/error.h"

namespace thixo {
namespace {

using namespace std::chrono_literals;

/// Work that never asks whether it was interrupted.
void work_after(int signal_number, const std::function<void()>& save) {
    catch_interrupts();
    const InterruptionWatch watch("program", save);
    std::raise(signal_number);
    std::this_thread::sleep_for(20s);
    std::_Exit(99);
}

TEST(InterruptionWatchDeathTest, AnswersWithinTwoSecondsWhateverTheWork) {
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_EXIT(work_after(SIGTERM, [] { std::fputs("saved, ", stderr); }), testing::ExitedWithCode(kTerminated),
                "saved, program: interrupted");
    EXPECT_LT(std::chrono::steady_clock::now() - begun, 2s);
    EXPECT_EXIT(work_after(SIGINT, [] {}), testing::ExitedWithCode(kInterrupted), "program: interrupted");
}

TEST(InterruptionWatchDeathTest, TellsWhyNothingCouldBeSaved) {
    EXPECT_EXIT(work_after(SIGINT, [] { throw ResourceError("the disk is full"); }),
                testing::ExitedWithCode(kNoResource), "program: the disk is full");
}

TEST(InterruptionWatchDeathTest, LeavesWorkAloneThatEndsByItself) {
    const auto work = [] {
        catch_interrupts();
        {
            const InterruptionWatch watch("program", [] { std::_Exit(99); });
            std::raise(SIGINT);
            std::this_thread::sleep_for(200ms);
        }
        std::this_thread::sleep_for(1500ms);
        std::_Exit(kDone);
    };
    EXPECT_EXIT(work(), testing::ExitedWithCode(kDone), "");
}

}  // namespace
}  // namespace thixo
