#include "pipeline/driver/scratch_folder.h"

#include <gtest/gtest.h>

#include <fstream>

#include "pipeline/base/error.h"
#include "tests/pipeline/driver/temporary_folder.h"

namespace thixo {
namespace {

TEST(ScratchFolder, IsEmptyAtFirstAndGoneAtTheEnd) {
    const TemporaryFolder folder;
    const std::filesystem::path path = folder.path / "a" / "b";
    std::filesystem::create_directories(path / "left by a killed process");
    {
        const ScratchFolder scratch(path);
        EXPECT_TRUE(std::filesystem::is_empty(path));
        std::ofstream(path / "file") << "x";
    }
    EXPECT_FALSE(std::filesystem::exists(path));
    EXPECT_TRUE(std::filesystem::exists(path.parent_path()));
}

TEST(ScratchFolder, RefusesAPlaceThatCannotBe) {
    const TemporaryFolder folder;
    std::ofstream(folder.path / "file") << "x";
    EXPECT_THROW(ScratchFolder(folder.path / "file" / "below"), ResourceError);
}

}  // namespace
}  // namespace thixo
