#include "pipeline/driver/conduct.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/contract/cache.h"
#include "tests/pipeline/driver/temporary_folder.h"

namespace thixo {
namespace {
namespace fs = std::filesystem;

/// Stages in place of the real ones: shell scripts that note when they were called, with which words, and when they
/// ended.
class Conduct : public testing::Test {
  protected:
    Conduct() {
        setenv("THIXO_BIN", folder_.path.c_str(), 1);
        stages_.sim.scene = "s.yaml";
        stages_.sim.out = stages_.render.out = (folder_.path / "out").string();
    }
    ~Conduct() override { unsetenv("THIXO_BIN"); }

    void stage(const std::string& name, const std::string& script) {
        const fs::path file = folder_.path / name;
        std::ofstream(file) << "#!/bin/sh\nnote() { echo \"$*\" >> '" << notes().string() << "'; }\nnote " << name
                            << " started \"$@\"\n"
                            << script << "\n";
        fs::permissions(file, fs::perms::owner_all);
    }
    fs::path notes() const { return folder_.path / "notes"; }
    bool noted(const std::string& text) const { return text_of(notes()).find(text) != std::string::npos; }
    std::size_t when(const std::string& text) const { return text_of(notes()).find(text); }

    /// A cache with frames of one particle each, as a failed simulation leaves it.
    void cache_with_frames(int count) const {
        CacheWriter writer = CacheWriter::create(stages_.sim.out, {"s", "", "0"});
        for (int n = 1; n <= count; ++n) {
            Frame frame;
            frame.number = n;
            frame.spacing = 0.1;
            for (PointSet* points : {&frame.particles, &frame.surfels}) {
                points->count = 1;
                points->add("P", std::vector<Vec3f>{{0, 0, 0}});
            }
            writer.write_frame(frame);
        }
    }
    int conduct_quietly() const { return conduct(stages_, {.terminal = false, .quiet = true}); }

    TemporaryFolder folder_;
    Stages stages_;
};

TEST_F(Conduct, RenderingStartsOnlyWhenTheCacheWasAccepted) {
    stage("thixo-sim", "sleep 0.3; note accepted; echo '@progress sim 0 2 x' >&2; sleep 0.3; note sim done");
    stage("thixo-render", "note render done");
    EXPECT_EQ(0, conduct_quietly());
    EXPECT_LT(when("accepted"), when("thixo-render started"));
    EXPECT_LT(when("thixo-render started"), when("sim done"));
    EXPECT_TRUE(noted("--follow"));
}

TEST_F(Conduct, AFinishedCacheIsRenderedWithoutWaiting) {
    stage("thixo-sim", "exit 0");
    stage("thixo-render", "note render done");
    EXPECT_EQ(0, conduct_quietly());
    EXPECT_TRUE(noted("render done"));
}

TEST_F(Conduct, ARefusedCacheIsNotRendered) {
    stage("thixo-sim", "exit 2");
    stage("thixo-render", "");
    EXPECT_EQ(2, conduct_quietly());
    EXPECT_FALSE(noted("thixo-render started"));
}

TEST_F(Conduct, WhatAFailedSimulationCachedIsRendered) {
    cache_with_frames(3);
    stages_.render.frames = "2-9";
    stage("thixo-sim", "echo '@progress sim 1 9 x' >&2; sleep 0.5; exit 3");
    stage("thixo-render",
          "case \"$*\" in *--follow*) trap 'note follower told; exit 143' TERM; while :; do sleep 0.05; done;; esac; "
          "note rest done");
    EXPECT_EQ(3, conduct_quietly());
    EXPECT_LT(when("follower told"), when("rest done"));
    EXPECT_TRUE(noted("--frames=2,3")) << text_of(notes());
}

TEST_F(Conduct, AFailedRenderingDoesNotStopTheSimulation) {
    stage("thixo-sim", "echo '@progress sim 0 9 x' >&2; sleep 0.5; note sim done");
    stage("thixo-render", "exit 5");
    EXPECT_EQ(5, conduct_quietly());
    EXPECT_TRUE(noted("sim done"));
}

TEST_F(Conduct, ACrashOfTheSimulationIsReported) {
    stage("thixo-sim", "kill -SEGV $$");
    stage("thixo-render", "");
    try {
        conduct_quietly();
        FAIL() << "a crash went by";
    } catch (const Error& e) {
        EXPECT_EQ(128 + SIGSEGV, e.code());
        EXPECT_NE(std::string::npos, std::string(e.what()).find("thixo-sim crashed")) << e.what();
    }
}

TEST_F(Conduct, PassesMessagesOnAndKeepsProgressTogether) {
    stage("thixo-sim",
          "echo '@progress sim 1 2 a' >&2; echo 'warning: thin' >&2; echo 'thixo-sim: bad scene' >&2; exit 2");
    stage("thixo-render", "");
    cache_with_frames(1);
    testing::internal::CaptureStderr();
    EXPECT_EQ(2, conduct(stages_, {.terminal = false, .quiet = false}));
    EXPECT_EQ("sim 1/2  a\nwarning: thin\nthixo-sim: bad scene\n", testing::internal::GetCapturedStderr());
}

TEST_F(Conduct, AnInterruptReachesBothStages) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    stage("thixo-sim",
          "trap 'note sim told; exit 130' INT; echo '@progress sim 0 9 x' >&2; while :; do sleep 0.05; done");
    stage("thixo-render",
          "trap 'note render told; exit 130' INT; echo '@progress render 0 9 x' >&2; note render ready; kill -INT "
          "$PPID; while :; do sleep 0.05; done");
    EXPECT_EXIT(
        {
            catch_interrupts();
            try {
                conduct_quietly();
            } catch (const InterruptedError& e) {
                std::exit(noted("sim told") && noted("render told") ? e.code() : 1);
            }
            std::exit(2);
        },
        testing::ExitedWithCode(130), "");
}

}  // namespace
}  // namespace thixo
