#include "pipeline/driver/scratch_folder.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "pipeline/base/error.h"
#include "tests/pipeline/driver/temporary_folder.h"

namespace thixo {
namespace {
namespace fs = std::filesystem;

TEST(ScratchFolder, IsEmptyAtFirstAndGoneAtTheEnd) {
    const TemporaryFolder folder;
    {
        const ScratchFolder scratch(folder.path / "a", "film");
        EXPECT_TRUE(fs::is_empty(scratch.path()));
        std::ofstream(scratch.path() / "file") << "x";
    }
    EXPECT_TRUE(fs::is_empty(folder.path / "a"));
}

TEST(ScratchFolder, RemovesWhatAKilledProcessLeftAndNothingElse) {
    const TemporaryFolder folder;
    fs::create_directories(folder.path / ".film" / "of another program");
    const pid_t child = fork();
    if (child == 0) {
        const ScratchFolder scratch(folder.path, "film");
        std::ofstream(scratch.path() / "000000.png") << "x";
        raise(SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
    { const ScratchFolder scratch(folder.path, "film"); }
    EXPECT_EQ(1, std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()));
    EXPECT_TRUE(fs::exists(folder.path / ".film" / "of another program"));
}

TEST(ScratchFolder, TwoProcessesAtOnceDoNotShareOne) {
    const TemporaryFolder folder;
    const ScratchFolder ours(folder.path, "film");
    std::ofstream(ours.path() / "file") << "x";
    const pid_t child = fork();
    if (child == 0) {
        const bool apart = ScratchFolder(folder.path, "film").path() != ours.path();
        _exit(apart ? 0 : 1);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(0, status);
    EXPECT_TRUE(fs::exists(ours.path() / "file"));
}

TEST(ScratchFolder, RefusesAPlaceThatCannotBe) {
    const TemporaryFolder folder;
    std::ofstream(folder.path / "file") << "x";
    EXPECT_THROW(ScratchFolder(folder.path / "file" / "below", "film"), ResourceError);
}

}  // namespace
}  // namespace thixo
