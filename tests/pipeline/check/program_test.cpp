// thixo-check as a program: arguments, exit codes, JSON.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "pipeline/contract/check_args.h"
#include "pipeline/contract/image.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo {
namespace {

TEST(CheckArgs, ParsesWhatItPrints) {
    CheckArgs a;
    a.path = "--odd name";
    a.against = "ref erence";
    a.frames = "1-9x2";
    a.max_rel_mse = 0.1 + 0.2;  // no short decimal
    a.diff = "d";
    a.threads = 2;
    a.update = a.json = a.quiet = true;
    const CheckArgs b = CheckArgs::parse(a.print());
    EXPECT_EQ(b.path, a.path);
    EXPECT_EQ(b.max_rel_mse, a.max_rel_mse);
    EXPECT_EQ(b.print(), a.print());
    const CheckArgs plain = CheckArgs::parse({"x", "--against", "y"});
    EXPECT_EQ(CheckArgs::parse(plain.print()).print(), plain.print());
}

class CheckProgram : public ::testing::Test {
  protected:
    void SetUp() override {
        for (const char* side : {"a", "b"}) {
            make_folder(folder_ / side);
            write(side, 0.5f);
        }
    }
    void write(const std::string& side, float value) {
        Image image(8, 8);
        image.add("R", false).assign(64, value);
        write_exr(folder_ / side / "beauty.0001.exr", image);
    }
    int run(const std::string& words) {
        const std::string command =
            "cd '" + folder_.path().string() + "' && '" THIXO_BIN_DIR "/thixo-check' " + words + " >out 2>err";
        const int status = std::system(command.c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    test::TemporaryFolder folder_;
};

TEST_F(CheckProgram, ExitsByTheTableOfCodes) {
    EXPECT_EQ(run("a --against b"), kDone);
    EXPECT_EQ(run("a/beauty.0001.exr --against b/beauty.0001.exr"), kDone);
    write("a", 0.625f);
    EXPECT_EQ(run("a --against b"), kDifferent);
    EXPECT_EQ(run("a"), kBadInput);
    EXPECT_EQ(run("a --against b --frames x"), kBadInput);
    EXPECT_EQ(run("a --against b --max-rel-mse -1"), kBadInput);
    EXPECT_EQ(run("a --against nowhere"), kBadCache);
    EXPECT_EQ(run("out --against b"), kBadInput);
    write_whole(folder_ / "a" / "beauty.0001.exr", "damaged");
    EXPECT_EQ(run("a --against b"), kBadCache);
}

TEST_F(CheckProgram, ReportsInJson) {
    write("a", 0.625f);
    EXPECT_EQ(run("a --against b --json"), kDifferent);
    const auto report = nlohmann::json::parse(read_whole(folder_ / "out"));
    EXPECT_EQ(report["same"], false);
    EXPECT_EQ(report["tier"], "exact");
    const auto& frame = report["frames"].at(0);
    EXPECT_EQ(frame["name"], "beauty.0001.exr");
    EXPECT_EQ(frame["pixels_different"], 64);
    EXPECT_EQ(frame["max_abs"], 0.125);
    EXPECT_EQ(frame["worst"]["channel"], "R");
}

TEST_F(CheckProgram, UpdatesAndSaysSo) {
    write("a", 0.625f);
    EXPECT_EQ(run("a --against b --update"), kDone);
    EXPECT_NE(read_whole(folder_ / "out").find("replaced beauty.0001.exr"), std::string::npos);
    EXPECT_EQ(run("a --against b"), kDone);
    EXPECT_EQ(run("a --against a --update"), kBadInput);
}

}  // namespace
}  // namespace thixo
