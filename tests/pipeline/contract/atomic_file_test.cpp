#include "pipeline/contract/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <memory>
#include <thread>

#include "pipeline/contract/folder_lock.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

std::size_t files_in(const fs::path& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(AtomicFile, WritesAndReplacesWholeFiles) {
    const TemporaryFolder folder;
    for (const std::string& bytes : {std::string("first"), std::string(3'000'000, 'x'), std::string()}) {
        write_whole(folder / "file", bytes);
        EXPECT_EQ(read_whole(folder / "file"), bytes);
    }
    EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(AtomicFile, AFileSizeLimitLeavesTheOldFile) {
    const TemporaryFolder folder;
    write_whole(folder / "file", "old");
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
    const rlimit small{100'000, limit.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const std::string message =
        message_of([&] { write_whole(folder / "file", std::string(1'000'000, 'x')); }, kNoResource);
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, old_handler);
    EXPECT_NE(message.find((folder / "file").string() + "': File too large"), std::string::npos) << message;
    EXPECT_EQ(read_whole(folder / "file"), "old");
    EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(AtomicFile, AReadOnlyFolderKeepsWhatItHas) {
    const TemporaryFolder folder;
    write_whole(folder / "file", "old");
    fs::permissions(folder.path(), fs::perms(0555));
    // Root may write anywhere: become another user for the attempt.
    const uid_t user = ::geteuid();
    if (user == 0) {
        ASSERT_EQ(::seteuid(65534), 0);
    }
    const std::string message = message_of([&] { write_whole(folder / "file", "new"); }, kNoResource);
    const std::string no_folder = message_of([&] { make_folder(folder / "sub"); }, kNoResource);
    if (user == 0) {
        ASSERT_EQ(::seteuid(user), 0);
    }
    fs::permissions(folder.path(), fs::perms(0755));
    EXPECT_NE(message.find("Permission denied"), std::string::npos) << message;
    EXPECT_NE(no_folder.find("Permission denied"), std::string::npos) << no_folder;
    EXPECT_EQ(read_whole(folder / "file"), "old");
    EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(AtomicFile, AFullDiskAtAnyByteLeavesTheOldFile) {
    const TemporaryFolder folder;
    write_whole(folder / "file", "old");
    for (const int bytes : {0, 1, 4096, 999'999}) {
        const int status = in_child("1:" + std::to_string(bytes) + ":enospc", [&] {
            write_whole(folder / "file", std::string(1'000'000, 'x'));
            return 0;
        });
        ASSERT_TRUE(WIFEXITED(status));
        EXPECT_EQ(WEXITSTATUS(status), kNoResource);
        EXPECT_EQ(read_whole(folder / "file"), "old");
        EXPECT_EQ(files_in(folder.path()), 1u);
    }
}

TEST(AtomicFile, AKilledWriterLeavesTheOldFileAndItsTemporaryIsRemovedLater) {
    const TemporaryFolder folder;
    write_whole(folder / "file", "old");
    const int status = in_child("1:10:kill", [&] {
        write_whole(folder / "file", "a new text that is longer");
        return 0;
    });
    ASSERT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(WTERMSIG(status), SIGKILL);
    EXPECT_EQ(read_whole(folder / "file"), "old");
    EXPECT_EQ(files_in(folder.path()), 2u);
    EXPECT_EQ(remove_stale_temporaries(folder.path()), 1);
    EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(AtomicFile, ATemporaryOfAnEndedProcessIsRemovedEvenWhileNobodyAsksForItsExitCode) {
    const TemporaryFolder folder;
    const pid_t child = ::fork();
    if (child == 0) ::_exit(0);
    siginfo_t ended{};
    ASSERT_EQ(::waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT), 0);  // it stays a zombie
    std::string name = temporary_path(folder.path(), "file").filename().string();
    const std::string own = std::to_string(::getpid());
    name.replace(name.find(own), own.size(), std::to_string(child));
    std::ofstream(folder / name) << "half";
    EXPECT_EQ(remove_stale_temporaries(folder.path()), 1);
    EXPECT_EQ(files_in(folder.path()), 0u);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
}

TEST(AtomicFile, ATemporaryIsRemovedWhereItsProcessIsAnotherOneByNow) {
    const TemporaryFolder folder;
    std::string name = temporary_path(folder.path(), "file").filename().string();
    const pid_t child = ::fork();
    if (child == 0) {
        ::pause();
        ::_exit(0);
    }
    const std::string own = std::to_string(::getpid());
    name.replace(name.find(own), own.size(), std::to_string(child));
    std::ofstream(folder / name) << "half";
    EXPECT_EQ(remove_stale_temporaries(folder.path()), 0) << "its writer lives";
    // Last changed before that process began: the number has been used again.
    fs::last_write_time(folder / name, fs::file_time_type::clock::now() - std::chrono::minutes(1));
    EXPECT_EQ(remove_stale_temporaries(folder.path()), 1);
    ::kill(child, SIGKILL);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
}

TEST(AtomicFile, TemporariesOfLivingProcessesAndOtherFilesStay) {
    const TemporaryFolder folder;
    char host[256] = {};
    ASSERT_EQ(::gethostname(host, sizeof host - 1), 0);
    // Our parent lives; the other host may live.
    const std::string ours = ".thixo-" + std::to_string(::getppid()) + "-" + host + "-file.tmp",
                      other = ".thixo-1-elsewhere.example-file.tmp";
    for (const std::string& name : {ours, other, std::string("notes.tmp"), std::string(".thixo-x.tmp")})
        write_whole(folder / name, "x");
    EXPECT_EQ(remove_stale_temporaries(folder.path()), 0);
    EXPECT_EQ(files_in(folder.path()), 4u);
    fs::last_write_time(folder / other, fs::file_time_type::clock::now() - std::chrono::hours(2));
    EXPECT_EQ(remove_stale_temporaries(folder.path()), 1);
    EXPECT_EQ(remove_stale_temporaries(folder / "not there"), 0);
}

TEST(AtomicFile, NothingIsWrittenThroughALink) {
    const TemporaryFolder folder, elsewhere;
    fs::create_symlink(elsewhere / "made", folder / "dangling");
    fs::create_symlink(elsewhere.path(), folder / "sub");
    EXPECT_NE(message_of([&] { write_whole(folder / "dangling", "x"); }, kBadInput).find("is a link"),
              std::string::npos);
    EXPECT_FALSE(append_line(folder / "dangling", "x"));
    EXPECT_NE(message_of([&] { make_subfolder(folder.path(), "sub/assets"); }, kBadInput).find("is a link"),
              std::string::npos);
    fs::create_symlink(elsewhere / "made", folder / ".lock");
    EXPECT_NE(message_of([&] { FolderLock lock(folder.path()); }, kBadInput).find("is a link"), std::string::npos);
    EXPECT_TRUE(fs::is_empty(elsewhere.path()));
}

TEST(AtomicFile, NothingIsReadThroughALinkInAFolderOfOthers) {
    const TemporaryFolder folder, elsewhere;
    write_whole(elsewhere / "secret", "secret");
    fs::create_symlink(elsewhere / "secret", folder / "file");
    fs::create_symlink(elsewhere.path(), folder / "sub");
    for (const char* name : {"file", "sub/secret"})
        EXPECT_NE(message_of([&] { read_inside(folder.path(), name, 100); }, kBadCache), "") << name;
    write_whole(folder / "own", "12345");
    EXPECT_EQ(read_inside(folder.path(), "own", 5), "12345");
    EXPECT_NE(message_of([&] { read_inside(folder.path(), "own", 4); }, kBadCache).find("5 bytes where at most 4"),
              std::string::npos);
}

TEST(FolderLock, AHolderThatIsEndingIsWaitedFor) {
    const TemporaryFolder folder;
    std::thread ending;
    {
        const FolderLock held(folder.path());
        EXPECT_NE(message_of([&] { FolderLock second(folder.path()); }, kBadInput).find("is being written"),
                  std::string::npos);
    }
    auto held = std::make_unique<FolderLock>(folder.path());
    ending = std::thread([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
        held.reset();
    });
    EXPECT_NO_THROW(FolderLock second(folder.path()));
    ending.join();
}

TEST(AtomicFile, AFolderThatIsMissingIsNamed) {
    const TemporaryFolder folder;
    const std::string message = message_of([&] { write_whole(folder / "no/file", "x"); }, kNoResource);
    EXPECT_NE(message.find("no/file': No such file or directory"), std::string::npos) << message;
}

TEST(AtomicFile, ReadingNamesWhatIsNotAFile) {
    const TemporaryFolder folder;
    EXPECT_NE(message_of([&] { read_whole(folder / "none"); }, kBadCache).find("none' is missing"), std::string::npos);
    EXPECT_NE(message_of([&] { read_whole(folder.path()); }, kBadCache).find("not a regular file"), std::string::npos);
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_NE(message_of([&] { read_whole(folder / "pipe"); }, kBadCache).find("not a regular file"),
              std::string::npos);
}

}  // namespace
}  // namespace thixo::test
