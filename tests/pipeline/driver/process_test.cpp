#include "pipeline/driver/process.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>

#include "pipeline/base/error.h"
#include "tests/pipeline/driver/temporary_folder.h"

namespace thixo {
namespace {

ProgramCall shell(const std::string& script) { return {"script", "/bin/sh", {"-c", script}}; }

template <class F>
std::string error_text(F&& f, int* code = nullptr) {
    try {
        f();
    } catch (const Error& e) {
        if (code) *code = e.code();
        return e.what();
    }
    return {};
}

TEST(Process, PassesTheExitCodeOnUnchanged) {
    for (const int code : {0, 1, 2, 3, 4, 5, 130, 143})
        EXPECT_EQ(code, run_to_end(shell("exit " + std::to_string(code))));
}

TEST(Process, ReturnsEveryLineOfStdout) {
    std::string out;
    EXPECT_EQ(0, run_to_end(shell("for i in 1 2 3; do echo line $i; done; printf 'no newline'"), &out));
    EXPECT_EQ("line 1\nline 2\nline 3\nno newline\n", out);
}

TEST(Process, ReturnsMoreThanAPipeHolds) {
    std::string out;
    EXPECT_EQ(0, run_to_end(shell("seq 1 100000"), &out));
    EXPECT_EQ(588895u, out.size());  // 9 + 90*2 + ... digits and 100000 newlines
}

TEST(Process, ArgumentsArriveAsTheyAre) {
    std::string out;
    const std::vector<std::string> words{"a b", "", "$HOME", "'\"\\", "*", "-x"};
    std::vector<std::string> args{"-c", "for w in \"$@\"; do printf '[%s]\\n' \"$w\"; done", "sh"};
    args.insert(args.end(), words.begin(), words.end());
    EXPECT_EQ(0, run_to_end({"script", "/bin/sh", args}, &out));
    std::string expected;
    for (const std::string& w : words) expected += "[" + w + "]\n";
    EXPECT_EQ(expected, out);
}

TEST(Process, ShellLineDoesTheSameAsTheCall) {
    const ProgramCall call{"printf", "/usr/bin/printf", {"[%s]\\n", "a b", "", "$HOME", "it's", "*", "~", "a;b", "-x"}};
    std::string direct, through_shell;
    ASSERT_EQ(0, run_to_end(call, &direct));
    ASSERT_EQ(0, run_to_end(shell(shell_line(call)), &through_shell));
    EXPECT_EQ(direct, through_shell);
}

TEST(Process, ACrashIsSaidClearly) {
    int code = 0;
    const std::string text = error_text([] { run_to_end(shell("kill -SEGV $$")); }, &code);
    EXPECT_EQ(128 + SIGSEGV, code);
    EXPECT_NE(std::string::npos, text.find("script crashed (Segmentation fault)")) << text;
}

TEST(Process, AKillIsTakenForLackOfMemory) {
    int code = 0;
    const std::string text = error_text([] { run_to_end(shell("kill -KILL $$")); }, &code);
    EXPECT_EQ(kNoResource, code);
    EXPECT_NE(std::string::npos, text.find("memory")) << text;
}

TEST(Process, AMissingProgramIsNamed) {
    int code = 0;
    const std::string text = error_text([] { run_to_end({"thixo-sim", "/nonexistent/thixo-sim", {}}); }, &code);
    EXPECT_EQ(kBadInput, code);
    EXPECT_NE(std::string::npos, text.find("/nonexistent/thixo-sim")) << text;
    EXPECT_NE(std::string::npos, text.find("No such file")) << text;
}

TEST(Process, TellReachesTheChildrenOfTheChildToo) {
    const TemporaryFolder folder;
    const std::string mark = (folder.path / "late").string();
    Process process = start(shell("(sleep 1; : > '" + mark + "') & echo ready; wait"), {.out = true});
    Process* const all[] = {&process};
    bool ready = false;
    while (!ready) wait_a_moment(all, [&](Process&, bool, const std::string& line) { ready = line == "ready"; });
    tell(process, SIGTERM);
    while (!process.status) wait_a_moment(all, [](Process&, bool, const std::string&) {});
    EXPECT_TRUE(WIFSIGNALED(*process.status));
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    EXPECT_FALSE(std::filesystem::exists(mark));
}

TEST(Process, ASignalToTheDriverReachesTheChildOnce) {
    testing::FLAGS_gtest_death_test_style = "threadsafe";  // handlers and the note of the signal outlive the test
    EXPECT_EXIT(
        {
            catch_interrupts();
            Process process =
                start(shell("trap 'echo told; exit 130' INT; echo ready; while :; do sleep 0.05; done"), {.out = true});
            Process* const all[] = {&process};
            int told = 0;
            while (!process.status)
                wait_a_moment(all, [&](Process&, bool, const std::string& line) {
                    if (line == "ready") std::raise(SIGINT);
                    told += line == "told";
                });
            std::exit(told == 1 && exit_code(process) == 130 ? 42 : 1);
        },
        testing::ExitedWithCode(42), "");
}

TEST(Process, TheChildEndsWhenTheDriverIsKilled) {
    const TemporaryFolder folder;
    const std::string mark = (folder.path / "told").string();
    const pid_t driver = fork();
    ASSERT_GE(driver, 0);
    if (driver == 0) {
        const Process process = start(shell("trap ': > \"" + mark + "\"; exit 143' TERM; : > \"" + mark +
                                            ".ready\"; while :; do sleep 0.05; done"));
        for (;;) pause();
    }
    for (int i = 0; i < 200 && !std::filesystem::exists(mark + ".ready"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    kill(driver, SIGKILL);
    waitpid(driver, nullptr, 0);
    for (int i = 0; i < 200 && !std::filesystem::exists(mark); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_TRUE(std::filesystem::exists(mark));
}

}  // namespace
}  // namespace thixo
