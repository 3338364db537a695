// Stages and ffmpeg as child processes: each in a group of its own, told of SIGINT and SIGTERM, and ended when this
// process ends.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace thixo {

/// A program and its arguments. `name` is what messages call it, `folder` where it works; empty: this process's.
struct ProgramCall {
    std::string name;
    std::filesystem::path program;
    std::vector<std::string> args;
    std::filesystem::path folder{};
};

/// The call as a line for a POSIX shell.
std::string shell_line(const ProgramCall& call);

/// Streams of a child that come back here line by line; the others are those of this process.
struct Capture {
    bool out = false;
    bool err = false;
};

struct Process {
    ProgramCall call;
    pid_t id = -1;
    int id_fd = -1;                  // readable when the process has ended
    int out_fd = -1, err_fd = -1;    // -1: not captured, or at its end
    std::string out_rest, err_rest;  // begun lines
    std::optional<int> status;       // as of waitpid, once it has ended and its streams are read
    bool told = false;               // a signal was passed on
};

/// Throws InputError where the program cannot be started (naming the reason), ResourceError where the system has no
/// room for a process.
Process start(ProgramCall call, Capture capture = {});

using LineHandler = std::function<void(Process& from, bool err, const std::string& line)>;

/// Waits until one of the processes says a line or ends, at most a quarter of a second. Passes a signal that arrived on
/// to all of them.
void wait_a_moment(std::span<Process* const> running, const LineHandler& on_line);

/// Sends a signal to the process and its children.
void tell(Process& process, int signal_number);

/// The exit code of an ended process. Where a signal ended it, throws Error that says so: code 5 for SIGKILL (what the
/// system does when memory runs out), else 128 + signal.
int exit_code(const Process& process);

/// Starts, waits, and returns the exit code (see exit_code). Lines captured from stdout are returned in `out`, where
/// given.
int run_to_end(ProgramCall call, std::string* out = nullptr);

}  // namespace thixo
