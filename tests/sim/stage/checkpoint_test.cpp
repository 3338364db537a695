#include "sim/stage/checkpoint.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/contract/atomic_file.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

namespace fs = std::filesystem;

// A tank with a falling drop and a jet, so that emitters, walls, surface and impact all have state.
scene::Scene splash(scene::Pressure pressure = scene::Pressure::eos) {
    scene::Scene s = fixture::tank({0.12, 0.12, 0.2}, 0.03, 0.01);
    s.bodies.push_back(fixture::body("drop", fixture::shape_at({0, 0, 0.08}, scene::Sphere{0.02}), {0.1, 0, -1}));
    scene::Emitter e;
    e.name = "spout";
    e.material = "water";
    e.position = {0.02, 0.02, 0.15};
    e.radius = 0.012;
    e.jitter = 0.1;
    s.emitters = {e};
    s.surface.enabled = true;
    s.frames.fps = 300;
    s.solver.pressure = pressure;
    if (pressure == scene::Pressure::dfsph) s.frames.fps = 60;  // longer steps
    return s;
}

/// The clock as it stands at the end of a frame.
void set_frame(int frame, Simulation& s) {
    s.clock.frame = frame;
    s.clock.time = frame_time(s.problem.scene.frames, frame);
}

class Checkpoint : public testing::Test {
  protected:
    void SetUp() override {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        out_ = fs::temp_directory_path() / (std::string("thixo_checkpoint_") + info->name() + std::to_string(getpid()));
        fs::remove_all(out_);
    }
    void TearDown() override { fs::remove_all(out_); }
    fs::path out_;
};

class CheckpointOf : public testing::TestWithParam<scene::Pressure> {};
INSTANTIATE_TEST_SUITE_P(Solvers, CheckpointOf, testing::Values(scene::Pressure::eos, scene::Pressure::dfsph));

TEST_P(CheckpointOf, ResumedRunEqualsTheUninterruptedOneBitForBit) {
    const scene::Scene scene = splash(GetParam());
    Simulation whole = make_simulation(scene);
    refresh_surface(whole);
    for (int k = 0; k < 2; ++k) advance_frame(whole);
    const std::string half = print_checkpoint(whole, "hash");
    for (int k = 0; k < 2; ++k) advance_frame(whole);
    Simulation resumed = make_simulation(scene);
    parse_checkpoint(half, "half", "hash", resumed);
    for (int k = 0; k < 2; ++k) advance_frame(resumed);
    EXPECT_GT(whole.surface.size(), 0u);
    EXPECT_GT(whole.clock.step, GetParam() == scene::Pressure::eos ? 20 : 8);
    EXPECT_TRUE(print_checkpoint(whole, "hash") == print_checkpoint(resumed, "hash"));
}

TEST_P(CheckpointOf, StateIsTheSameAtAnyThreadCount) {
    std::string first;
    for (const int threads : {1, 2, 3}) {
        set_thread_count(threads);
        Simulation s = make_simulation(splash(GetParam()));
        refresh_surface(s);
        for (int k = 0; k < 2; ++k) advance_frame(s);
        const std::string state = print_checkpoint(s, "hash");
        if (first.empty()) first = state;
        EXPECT_TRUE(state == first) << threads << " threads";
    }
    set_thread_count(0);
}

TEST_F(Checkpoint, KeepsTheLastTwo) {
    const Simulation s = make_simulation(splash());
    for (const int frame : {10, 20, 30}) write_checkpoint(out_, frame, print_checkpoint(s, "hash"));
    EXPECT_EQ(list_checkpoints(out_), (std::vector<int>{30, 20}));
}

TEST_F(Checkpoint, DamagedOnesAreSkippedForAnEarlierOne) {
    Simulation s = make_simulation(splash());
    set_frame(10, s);
    write_checkpoint(out_, 10, print_checkpoint(s, "hash"));
    set_frame(20, s);
    std::string bytes = print_checkpoint(s, "hash");
    for (const std::size_t at : {std::size_t(3), std::size_t(9), bytes.size() / 2, bytes.size() - 5}) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ 1);
        write_checkpoint(out_, 20, damaged);
        Simulation restored = make_simulation(splash());
        EXPECT_TRUE(restore_checkpoint(out_, 100, "hash", restored));
        EXPECT_EQ(restored.clock.frame, 10);
    }
    write_checkpoint(out_, 20, bytes.substr(0, bytes.size() / 3));
    Simulation restored = make_simulation(splash());
    EXPECT_TRUE(restore_checkpoint(out_, 100, "hash", restored));
    EXPECT_EQ(restored.clock.frame, 10);
}

TEST_F(Checkpoint, RefusedOnesAreSetAsideAndDisplaceNoGoodOne) {
    Simulation s = make_simulation(splash());
    const auto at = [&](int frame) {
        set_frame(frame, s);
        return print_checkpoint(s, "hash");
    };
    write_checkpoint(out_, 1, at(1));
    write_checkpoint(out_, 2, at(2));
    for (const char* name : {"checkpoint.0008.bin", "checkpoint.0009.bin"})
        write_whole(out_ / "checkpoint" / name, at(9) + "damaged");
    Simulation restored = make_simulation(splash());
    EXPECT_TRUE(restore_checkpoint(out_, 100, "hash", restored));
    EXPECT_EQ(restored.clock.frame, 2);
    EXPECT_EQ(list_checkpoints(out_), (std::vector<int>{2, 1}));
    EXPECT_EQ(read_whole(out_ / "checkpoint/refused.0009.1.bin"), at(9) + "damaged");
    write_checkpoint(out_, 3, at(3));
    EXPECT_EQ(list_checkpoints(out_), (std::vector<int>{3, 2}));
}

TEST_F(Checkpoint, OfAFrameThatTheRunPassesAgainDoNotDisplaceItsOwn) {
    Simulation s = make_simulation(splash());
    for (const int frame : {5, 6}) write_checkpoint(out_, frame, print_checkpoint(s, "hash"));
    for (const int frame : {2, 3}) write_checkpoint(out_, frame, print_checkpoint(s, "hash"));
    EXPECT_EQ(list_checkpoints(out_), (std::vector<int>{3, 2}));
}

TEST_F(Checkpoint, AFileOfAnotherProgramIsRenamedNotRemoved) {
    const Simulation s = make_simulation(splash());
    make_folder(out_ / "checkpoint");
    write_whole(out_ / "checkpoint/checkpoint.0007.bin", "mine");
    write_whole(out_ / "checkpoint/notes.bin", "mine too");
    write_checkpoint(out_, 3, print_checkpoint(s, "hash"));
    EXPECT_EQ(read_whole(out_ / "checkpoint/checkpoint.0007.bin"), "mine");
    remove_checkpoints(out_);
    EXPECT_TRUE(list_checkpoints(out_).empty());
    EXPECT_EQ(read_whole(out_ / "checkpoint/refused.0007.1.bin"), "mine");
    EXPECT_EQ(read_whole(out_ / "checkpoint/notes.bin"), "mine too");
}

TEST_F(Checkpoint, AnotherScenesIsRefused) {
    Simulation s = make_simulation(splash());
    const std::string bytes = print_checkpoint(s, "this scene");
    EXPECT_THROW(parse_checkpoint(bytes, "file", "that scene", s), CacheError);
    write_checkpoint(out_, 1, bytes);
    EXPECT_FALSE(restore_checkpoint(out_, 100, "that scene", s));
}

}  // namespace
}  // namespace thixo
