#include "pipeline/base/error.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>

namespace thixo {
namespace {
volatile std::sig_atomic_t pending_signal = 0;
void note_signal(int number) { pending_signal = number; }
}  // namespace

InterruptedError::InterruptedError(int signal_number)
    : Error(signal_number == SIGINT ? kInterrupted : kTerminated,
            "interrupted; the state is saved, the same command continues") {}

int run_guarded(const char* program, int (*body)(int, char**), int argc, char** argv) {
    try {
        return body(argc, argv);
    } catch (const Error& e) {
        std::fflush(stdout);
        fmt::print(stderr, "{}: {}\n", program, e.what());
        return e.code();
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "{}: out of memory; use fewer particles, a smaller picture, or a machine with more\n",
                   program);
        return kNoResource;
    } catch (const std::filesystem::filesystem_error& e) {
        std::fflush(stdout);
        fmt::print(stderr, "{}: {}: {}\n", program, e.path1().string(), e.code().message());
        return kNoResource;
    } catch (const std::exception& e) {
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
