#include "sim/stage/run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "sim/stage/checkpoint.h"

namespace thixo {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = R"(
frames: {first: 1, last: 5, fps: 48}
world:
  boundaries:
    tank: {shape: {box: {size: [0.1, 0.1, 0.2]}, translate: [0, 0, 0.1]}, inside: true}
materials: {water: {viscosity: 0.01}}
bodies:
  pool: {material: water, shape: {box: {size: [0.1, 0.1, 0.04]}, translate: [0, 0, 0.02]}}
emitters:
  spout: {material: water, position: [0, 0, 0.1], radius: 0.015, speed: 1}
solver: {spacing: 0.01, checkpoint_every: 2}
probes:
  mass: {measure: total}
  into: {measure: flux, position: [0, 0, 0.08], direction: [0, 0, -1]}
  nowhere: {measure: point, quantity: pressure, position: [9, 9, 9]}
)";

class Run : public testing::Test {
  protected:
    void SetUp() override {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::temp_directory_path() / (std::string("thixo_run_") + info->name() + std::to_string(getpid()));
        fs::remove_all(folder_);
        fs::create_directories(folder_);
        std::ofstream(folder_ / "scene.yaml") << kScene;
    }
    void TearDown() override { fs::remove_all(folder_); }
    SimArgs args(const std::string& out, const std::string& frames = "") const {
        SimArgs a;
        a.scene = (folder_ / "scene.yaml").string();
        a.out = (folder_ / out).string();
        a.frames = frames;
        a.quiet = true;
        return a;
    }
    std::map<std::string, std::string> files(const std::string& out) const {
        std::map<std::string, std::string> bytes;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / out / "cache"))
            if (entry.is_regular_file()) bytes[entry.path().filename().string()] = read_whole(entry.path());
        return bytes;
    }
    fs::path folder_;
};

TEST_F(Run, StoppedAndContinuedGivesTheBytesOfAnUninterruptedRun) {
    run_simulation(args("whole"));
    run_simulation(args("parts", "1-2"));
    run_simulation(args("parts", "1-4"));
    fs::remove(folder_ / "parts" / "checkpoint" / "checkpoint.0004.bin");  // as if killed before it was written
    run_simulation(args("parts"));
    EXPECT_GT(files("whole").size(), 10u);
    EXPECT_TRUE(files("whole") == files("parts"));
    EXPECT_TRUE(CacheReader(folder_ / "parts").complete());
    const std::string probes = read_whole(folder_ / "whole" / "probes.csv");
    EXPECT_TRUE(probes.starts_with("frame,time,mass,into,nowhere\n1,0,")) << probes;
    EXPECT_EQ(std::count(probes.begin(), probes.end(), '\n'), 6);
    EXPECT_EQ(probes, read_whole(folder_ / "parts" / "probes.csv"));
}

TEST_F(Run, WithoutCheckpointsItStartsOverToTheSameBytes) {
    run_simulation(args("whole", "1-3"));
    run_simulation(args("parts", "1-2"));
    remove_checkpoints(folder_ / "parts");
    run_simulation(args("parts", "1-3"));
    EXPECT_TRUE(files("whole") == files("parts"));
}

TEST_F(Run, WhatIsMissingOrDamagedInACompleteCacheIsMadeAgain) {
    run_simulation(args("whole"));
    run_simulation(args("out"));
    const auto whole = files("whole");
    const fs::path cache = folder_ / "out" / "cache";
    const std::string asset = CacheReader(folder_ / "out").manifest().assets.at(0).name;
    for (const std::string& name : {std::string("particles.0003.vdb"), std::string("frame.0005.json"), asset}) {
        fs::remove(cache / name);
        EXPECT_EQ(run_simulation(args("out")), kDone);
        EXPECT_TRUE(files("out") == whole) << name << " was removed";
        std::string flipped = read_whole(cache / name);
        flipped[flipped.size() / 2] ^= 1;
        write_whole(cache / name, flipped);
        EXPECT_EQ(run_simulation(args("out")), kDone);
        EXPECT_TRUE(files("out") == whole) << name << " was damaged";
    }
}

TEST_F(Run, TheStateIsSavedAlsoAmongDamagedCheckpointsOfLaterFrames) {
    run_simulation(args("out", "1-3"));
    for (const char* name : {"checkpoint.0008.bin", "checkpoint.0009.bin"})
        write_whole(folder_ / "out" / "checkpoint" / name, "THIXOCKP and no more");
    run_simulation(args("out", "1-4"));
    EXPECT_EQ(list_checkpoints(folder_ / "out"), (std::vector<int>{4, 3}));
}

TEST_F(Run, AForeignStatisticsFileIsRefusedAndStays) {
    make_folder(folder_ / "out");
    for (const char* name : {"stats.jsonl", "probes.csv"}) {
        write_whole(folder_ / "out" / name, "my own notes\n");
        EXPECT_THROW(run_simulation(args("out", "1")), InputError) << name;
        EXPECT_EQ(read_whole(folder_ / "out" / name), "my own notes\n");
        fs::remove(folder_ / "out" / name);
        fs::create_symlink(folder_ / "elsewhere", folder_ / "out" / name);
        EXPECT_THROW(run_simulation(args("out", "1")), InputError) << name;
        EXPECT_FALSE(fs::exists(folder_ / "elsewhere"));
        fs::remove(folder_ / "out" / name);
    }
}

TEST_F(Run, AnotherSimulationIsRefusedByTheNamesOfItsKeys) {
    run_simulation(args("out", "1"));
    SimArgs other = args("out");
    other.set = {"materials.water.viscosity=0.02"};
    try {
        run_simulation(other);
        FAIL() << "no error";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("materials.water.viscosity"), std::string::npos) << e.what();
        EXPECT_NE(std::string(e.what()).find("--restart"), std::string::npos) << e.what();
    }
    other.restart = true;
    other.frames = "1-2";
    EXPECT_EQ(run_simulation(other), kDone);
    EXPECT_EQ(CacheReader(folder_ / "out").frames(), (std::vector<int>{1, 2}));
}

TEST_F(Run, InitialWritesTheFirstFrameAndNoCheckpoint) {
    SimArgs initial = args("out");
    initial.initial = true;
    run_simulation(initial);
    EXPECT_EQ(CacheReader(folder_ / "out").frames(), std::vector<int>{1});
    EXPECT_TRUE(list_checkpoints(folder_ / "out").empty());
}

TEST_F(Run, FrameCarriesWhatTheCacheFormatPromises) {
    run_simulation(args("out", "1-3"));
    const Frame frame = CacheReader(folder_ / "out").load_frame(3);
    EXPECT_EQ(frame.time, 2 / 48.0);
    EXPECT_EQ(frame.bodies.size(), 2u);
    ASSERT_EQ(frame.obstacles.size(), 1u);
    EXPECT_EQ(frame.obstacles[0].name, "tank");
    EXPECT_FALSE(CacheReader(folder_ / "out").load_asset(frame.obstacles[0].asset).empty());
    for (const char* name :
         {"P", "v", "id", "pscale", "density", "pressure", "temperature", "body", "material", "kind"})
        EXPECT_NE(frame.particles.find(name), nullptr) << name;
    for (const char* name : {"P", "N", "t1", "t2", "id", "pscale", "body", "rest", "v", "temperature"})
        EXPECT_NE(frame.surfels.find(name), nullptr) << name;
    // The pool has the mass of its shape, and a drop of the spout a cube of the spacing.
    const double emitted = frame.totals.mass - 0.4;
    EXPECT_GT(emitted, 0.5e-3);
    EXPECT_NEAR(std::remainder(emitted, 1e-3), 0, 1e-5);
    EXPECT_NEAR(frame.totals.particle_volume, frame.totals.mass / 1000, 1e-8);
}

TEST_F(Run, FramesOutsideTheSceneAreRefused) { EXPECT_THROW(run_simulation(args("out", "1-9")), InputError); }

}  // namespace
}  // namespace thixo
