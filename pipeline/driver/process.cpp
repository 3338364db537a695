#include "pipeline/driver/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "pipeline/base/error.h"
#include "pipeline/contract/argument_words.h"

namespace thixo {
namespace {

struct Pipe {
    int read = -1, write = -1;
    void open() {
        std::array<int, 2> ends{};
        if (pipe2(ends.data(), O_CLOEXEC) != 0)
            throw ResourceError("cannot make a pipe: {}; close other programs", std::strerror(errno));
        read = ends[0];
        write = ends[1];
    }
    static void close_end(int& end) {
        if (end >= 0) close(end);
        end = -1;
    }
};

// Between fork and exec: system calls only.
[[noreturn]] void become(const ProgramCall& call, char* const* words, pid_t parent, int out, int err, int failure) {
    setpgid(0, 0);
    // The stage saves its state and ends when the driver is killed; getppid closes the gap before the call took effect.
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(kTerminated);
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
    if (out >= 0) dup2(out, STDOUT_FILENO);
    if (err >= 0) dup2(err, STDERR_FILENO);
    if (call.folder.empty() || chdir(call.folder.c_str()) == 0) execvp(call.program.c_str(), words);
    const int reason = errno;
    [[maybe_unused]] const ssize_t written = write(failure, &reason, sizeof reason);
    _exit(127);
}

/// Reads what is there; false at the end of the stream.
bool read_lines(Process& process, bool err, const LineHandler& on_line) {
    int& fd = err ? process.err_fd : process.out_fd;
    std::string& rest = err ? process.err_rest : process.out_rest;
    std::array<char, 65536> buffer;
    const ssize_t count = read(fd, buffer.data(), buffer.size());
    if (count < 0) return errno == EINTR || errno == EAGAIN;
    rest.append(buffer.data(), static_cast<std::size_t>(count));
    for (std::size_t end; (end = rest.find('\n')) != std::string::npos; rest.erase(0, end + 1))
        on_line(process, err, rest.substr(0, end));
    if (count > 0) return true;
    if (!rest.empty()) on_line(process, err, rest);
    rest.clear();
    Pipe::close_end(fd);
    return false;
}

void reap(Process& process) {
    int status = 0;
    if (waitpid(process.id, &status, WNOHANG) != process.id) return;
    process.status = status;
    Pipe::close_end(process.id_fd);
}

}  // namespace

std::string shell_line(const ProgramCall& call) {
    std::string line = call.folder.empty() ? "" : "cd -- " + shell_word(call.folder.string()) + " && ";
    line += shell_word(call.program.string());
    for (const std::string& word : call.args) line += " " + shell_word(word);
    return line;
}

Process start(ProgramCall call, Capture capture) {
    Pipe out, err, failure;
    if (capture.out) out.open();
    if (capture.err) err.open();
    failure.open();
    std::vector<char*> words{const_cast<char*>(call.program.c_str())};
    for (const std::string& word : call.args) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);

    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child < 0) throw ResourceError("cannot start {}: {}; close other programs", call.name, std::strerror(errno));
    if (child == 0) become(call, words.data(), parent, out.write, err.write, failure.write);
    setpgid(child, child);  // in both, so that neither has to wait for the other
    Pipe::close_end(out.write);
    Pipe::close_end(err.write);
    Pipe::close_end(failure.write);

    int reason = 0;
    const bool failed = read(failure.read, &reason, sizeof reason) == sizeof reason;
    Pipe::close_end(failure.read);
    if (failed) {
        waitpid(child, nullptr, 0);
        Pipe::close_end(out.read);
        Pipe::close_end(err.read);
        throw InputError("cannot start {} ({}): {}; build or install all of Thixo's programs into one folder",
                         call.name, call.program.string(), std::strerror(reason));
    }
    Process process;
    process.call = std::move(call);
    process.id = child;
    process.id_fd = static_cast<int>(
        syscall(SYS_pidfd_open, child, 0));  // -1 on an old kernel: then only the quarter second ends a wait
    process.out_fd = out.read;
    process.err_fd = err.read;
    return process;
}

void tell(Process& process, int signal_number) {
    if (!process.status) kill(-process.id, signal_number);
}

void wait_a_moment(std::span<Process* const> running, const LineHandler& on_line) {
    std::vector<pollfd> waited;
    for (const Process* p : running) {
        const bool reading = p->out_fd >= 0 || p->err_fd >= 0;
        for (const int fd : {p->out_fd, p->err_fd, reading ? -1 : p->id_fd})
            if (fd >= 0) waited.push_back({fd, POLLIN, 0});
    }
    poll(waited.data(), waited.size(), 250);
    const auto ready = [&](int fd) {
        return fd >= 0 &&
               std::any_of(waited.begin(), waited.end(), [&](const pollfd& w) { return w.fd == fd && w.revents != 0; });
    };
    for (Process* p : running) {
        if (const int number = interrupted(); number != 0 && !p->told) {
            p->told = true;
            tell(*p, number);
        }
        for (const bool err : {false, true})
            if (ready(err ? p->err_fd : p->out_fd)) read_lines(*p, err, on_line);
        if (p->out_fd < 0 && p->err_fd < 0) reap(*p);
    }
}

int exit_code(const Process& process) {
    const int status = process.status.value();
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    const int number = WTERMSIG(status);
    if (number == SIGKILL)
        throw ResourceError(
            "{} was killed, most likely because memory ran out; what it finished is safe, the same command continues",
            process.call.name);
    throw Error(static_cast<ExitCode>(128 + number),
                fmt::format("{} crashed ({}); what it finished is safe, the same command continues; "
                            "please report it with the command: {}",
                            process.call.name, strsignal(number), shell_line(process.call)));
}

int run_to_end(ProgramCall call, std::string* out) {
    Process process = start(std::move(call), {.out = out != nullptr});
    Process* const all[] = {&process};
    while (!process.status) {
        wait_a_moment(all, [&](Process&, bool, const std::string& line) { *out += line + "\n"; });
    }
    return exit_code(process);
}

}  // namespace thixo
