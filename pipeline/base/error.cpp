#include "pipeline/base/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <string_view>
#include <system_error>

#include "pipeline/base/printable.h"

namespace thixo {
namespace {
volatile std::sig_atomic_t pending_signal = 0;
void note_signal(int number) { pending_signal = number; }

constexpr const char* kRefused =
    "{}: the system refused: {}; free space, close other programs, or use fewer --threads\n";

/// oneTBB has no type of its own for a thread that the system refuses.
bool is_refused_thread(const std::exception& e) { return std::string_view(e.what()).starts_with("pthread_create"); }

/// Where libraries start threads, nobody may be there to catch what the system says to that. log4cplus, of OpenVDB, does
/// so before main. Embree does so where it lets no exception through.
void end_uncaught() {
    try {
        if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
    } catch (const std::system_error& e) {
        fmt::print(stderr, kRefused, program_invocation_short_name, e.what());
        std::_Exit(kNoResource);
    } catch (const std::exception& e) {
        if (is_refused_thread(e)) {
            fmt::print(stderr, kRefused, program_invocation_short_name, e.what());
            std::_Exit(kNoResource);
        }
    } catch (...) {
    }
    __gnu_cxx::__verbose_terminate_handler();
}
/// Run by the loader before the constructors of libraries.
[[gnu::section(".preinit_array"), gnu::used]] void (*const set_end_uncaught)() = [] {
    std::set_terminate(end_uncaught);
};

const char* running_program = "";
/// Before catch_interrupts nothing is under way that would have to be finished. System calls only.
[[noreturn]] void end_at_signal(int number) {
    for (const char* text : {running_program, ": interrupted\n"})
        [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text, std::strlen(text));
    ::_exit(number == SIGINT ? kInterrupted : kTerminated);
}

void set_signals(const char* program) {
    running_program = program;
    std::signal(SIGINT, end_at_signal);
    std::signal(SIGTERM, end_at_signal);
    std::signal(SIGXFSZ, SIG_IGN);
}

/// A closed standard stream would give its number to the first file that is opened, and messages would land in it.
void open_standard_streams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY);
}

}  // namespace

InterruptedError::InterruptedError(int signal_number)
    : Error(signal_number == SIGINT ? kInterrupted : kTerminated,
            "interrupted; the state is saved, the same command continues") {}

int run_guarded(const char* program, int (*body)(int, char**), int argc, char** argv) {
    open_standard_streams();
    set_signals(program);
    try {
        const int code = body(argc, argv);
        if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
            throw ResourceError("the answer cannot be written: {}; free space where it goes to", std::strerror(errno));
        return code;
    } catch (const Error& e) {
        std::fflush(stdout);
        fmt::print(stderr, "{}: {}\n", program, printable(e.what()));
        return e.code();
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "{}: out of memory; use fewer particles, a smaller picture, or a machine with more\n",
                   program);
        return kNoResource;
    } catch (const std::filesystem::filesystem_error& e) {
        std::fflush(stdout);
        fmt::print(stderr, "{}: {}: {}\n", program, printable(e.path1().string()), e.code().message());
        return kNoResource;
    } catch (const std::system_error& e) {  // of the standard library, or of fmt: streams, threads
        fmt::print(stderr, kRefused, program, e.what());
        return kNoResource;
    } catch (const std::exception& e) {
        if (is_refused_thread(e)) {
            fmt::print(stderr, kRefused, program, e.what());
            return kNoResource;
        }
        fmt::print(stderr, "{}: internal error: {}\n", program, e.what());
        return kBadInput;
    }
}

void assertion_failed(const char* file, int line, const char* expression, const std::string& message) {
    fmt::print(stderr, "{}:{}: assertion failed: {}: {}\n", file, line, expression, message);
    std::abort();
}

void catch_interrupts() {
    std::signal(SIGINT, note_signal);
    std::signal(SIGTERM, note_signal);
    std::signal(SIGXFSZ, SIG_IGN);
}
int interrupted() { return pending_signal; }

}  // namespace thixo
