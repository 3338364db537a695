#include "pipeline/base/error.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <new>

#include "pipeline/base/printable.h"

namespace thixo {
namespace {

using Body = int (*)(int, char**);

struct Outcome {
    int code;
    std::string message;
};
Outcome run(Body body) {
    testing::internal::CaptureStderr();
    const int code = run_guarded("thixo-x", body, 0, nullptr);
    return {code, testing::internal::GetCapturedStderr()};
}

TEST(Error, EachKindHasItsExitCode) {
    EXPECT_EQ(0, run([](int, char**) { return 0; }).code);
    EXPECT_EQ(1, run([](int, char**) { return int(kDifferent); }).code);
    EXPECT_EQ(2, run([](int, char**) -> int { throw InputError("a"); }).code);
    EXPECT_EQ(3, run([](int, char**) -> int { throw DivergedError("a"); }).code);
    EXPECT_EQ(4, run([](int, char**) -> int { throw CacheError("a"); }).code);
    EXPECT_EQ(5, run([](int, char**) -> int { throw ResourceError("a"); }).code);
    EXPECT_EQ(5, run([](int, char**) -> int { throw std::bad_alloc(); }).code);
    EXPECT_EQ(130, run([](int, char**) -> int { throw InterruptedError(SIGINT); }).code);
    EXPECT_EQ(143, run([](int, char**) -> int { throw InterruptedError(SIGTERM); }).code);
}

TEST(Error, TheMessageIsOneLineThatNamesTheProgram) {
    const Outcome outcome =
        run([](int, char**) -> int { throw InputError("no material '{}'; write one of {}", "watr", "water"); });
    EXPECT_EQ("thixo-x: no material 'watr'; write one of water\n", outcome.message);
}

TEST(Error, AThreadThatTheSystemRefusesEndsWith5EvenWhereALibraryLetsNoExceptionThrough) {
    const std::function<void()> refused = [] { throw std::runtime_error("pthread_create has failed: no memory"); };
    const auto no_exception_through = [&]() noexcept { refused(); };
    EXPECT_EXIT(no_exception_through(), testing::ExitedWithCode(kNoResource), "the system refused: pthread_create");
}

TEST(Error, ATextWithBracesPassesThrough) {
    const Outcome outcome = run([](int, char**) -> int { throw CacheError("{}", "a file named {0}"); });
    EXPECT_EQ("thixo-x: a file named {0}\n", outcome.message);
}

TEST(Error, WhatTheFileSystemRefusesIsToldByItsPath) {
    const Outcome outcome = run([](int, char**) -> int {
        std::filesystem::rename("/no/such/picture", "/no/such/other");
        return 0;
    });
    EXPECT_EQ(5, outcome.code);
    EXPECT_EQ("thixo-x: /no/such/picture: No such file or directory\n", outcome.message);
}

TEST(Error, AnUnexpectedExceptionIsReportedNotLost) {
    const Outcome outcome = run([](int, char**) -> int { throw std::out_of_range("vector"); });
    EXPECT_NE(0, outcome.code);
    EXPECT_NE(std::string::npos, outcome.message.find("internal error: vector"));
}

TEST(Error, WhatTheSystemRefusesIsAResourceError) {
    for (const auto body : {+[](int, char**) -> int { throw std::system_error(EAGAIN, std::generic_category()); },
                            +[](int, char**) -> int {
                                throw std::runtime_error("pthread_create has failed: Resource temporarily unavailable");
                            }}) {
        const Outcome outcome = run(body);
        EXPECT_EQ(kNoResource, outcome.code);
        EXPECT_NE(std::string::npos, outcome.message.find("Resource temporarily unavailable")) << outcome.message;
        EXPECT_EQ(1, std::count(outcome.message.begin(), outcome.message.end(), '\n')) << outcome.message;
    }
}

TEST(Error, AnAnswerThatCannotBeWrittenIsAResourceError) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_EXIT(
        {
            if (!std::freopen("/dev/full", "w", stdout)) std::exit(1);
            std::exit(run_guarded(
                "program",
                [](int, char**) {
                    std::fputs("{}\n", stdout);
                    return 0;
                },
                0, nullptr));
        },
        testing::ExitedWithCode(kNoResource), "program: the answer cannot be written: No space left");
}

TEST(Error, NamesDoNotSteerTheTerminal) {
    EXPECT_EQ("a\\x1b[2Jb\\x07\\x9b \n\tü€", printable("a\x1b[2Jb\x07\xc2\x9b \n\tü€"));
    const Outcome outcome = run([](int, char**) -> int { throw CacheError("no \x1b]0;title\x07"); });
    EXPECT_EQ("thixo-x: no \\x1b]0;title\\x07\n", outcome.message);
}

TEST(Error, ABrokenPromiseAborts) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_DEATH(THIXO_ASSERT(1 > 2, "particle {}", 7), "error_test.cpp:.*assertion failed: 1 > 2: particle 7");
}

TEST(Error, SignalsAreNotedNotObeyed) {
    // The test runs in a process of its own, because handlers and the noted signal outlive it.
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_EXIT(
        {
            catch_interrupts();
            const int before = interrupted();
            std::raise(SIGTERM);
            std::exit(before == 0 && interrupted() == SIGTERM ? 42 : 1);
        },
        testing::ExitedWithCode(42), "");
}

TEST(Error, SignalsBeforeThatEndTheProgramWithItsCodeAndAWord) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    const auto raising = [](int number) {
        static int raised = 0;
        raised = number;
        std::exit(run_guarded(
            "thixo-x", [](int, char**) { return std::raise(raised); }, 0, nullptr));
    };
    EXPECT_EXIT(raising(SIGINT), testing::ExitedWithCode(130), "^thixo-x: interrupted\n$");
    EXPECT_EXIT(raising(SIGTERM), testing::ExitedWithCode(143), "^thixo-x: interrupted\n$");
}

TEST(Error, AWriteBeyondTheFileSizeLimitFailsInsteadOfKilling) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";
    EXPECT_EXIT(
        {
            catch_interrupts();
            rlimit limit;
            limit.rlim_cur = limit.rlim_max = 10;
            setrlimit(RLIMIT_FSIZE, &limit);
            std::FILE* file = std::tmpfile();
            const bool written = std::fwrite("more than ten bytes", 1, 19, file) == 19 && std::fflush(file) == 0;
            std::exit(written ? 1 : errno == EFBIG ? 42 : 2);
        },
        testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace thixo
