// Failures that a user meets: one type each. Only main maps them to exit codes. A broken promise of our own is an
// assertion.
#pragma once

#include <fmt/core.h>

#include <stdexcept>
#include <string>

namespace thixo {

/// Exit codes of every Thixo program.
enum ExitCode : int {
    kDone = 0,
    kDifferent = 1,   ///< a check found a difference
    kBadInput = 2,    ///< bad usage or bad input
    kDiverged = 3,    ///< the simulation diverged
    kBadCache = 4,    ///< a cache is missing or damaged
    kNoResource = 5,  ///< out of memory or disk
    kInterrupted = 130,
    kTerminated = 143,
};

/// A failure with its exit code. The first line of what() is stable: what happened, where, what to do. More lines may
/// follow.
class Error : public std::runtime_error {
  public:
    Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    ExitCode code() const { return code_; }

  private:
    ExitCode code_;
};

/// The user's scene, mesh, look or command line is wrong (exit 2).
struct InputError : Error {
    template <class... A>
    explicit InputError(fmt::format_string<A...> f, A&&... a)
        : Error(kBadInput, fmt::format(f, std::forward<A>(a)...)) {}
};
/// The simulation left the domain of its method (exit 3).
struct DivergedError : Error {
    template <class... A>
    explicit DivergedError(fmt::format_string<A...> f, A&&... a)
        : Error(kDiverged, fmt::format(f, std::forward<A>(a)...)) {}
};
/// A cache, frame or checkpoint is missing, damaged or too new (exit 4).
struct CacheError : Error {
    template <class... A>
    explicit CacheError(fmt::format_string<A...> f, A&&... a)
        : Error(kBadCache, fmt::format(f, std::forward<A>(a)...)) {}
};
/// The disk is full or read-only, or memory ran out (exit 5).
struct ResourceError : Error {
    template <class... A>
    explicit ResourceError(fmt::format_string<A...> f, A&&... a)
        : Error(kNoResource, fmt::format(f, std::forward<A>(a)...)) {}
};
/// SIGINT or SIGTERM arrived; state was saved (exit 130 or 143).
struct InterruptedError : Error {
    explicit InterruptedError(int signal_number);
};

/// Runs a program's body, prints any failure to stderr as "program: message" and returns the exit code. An error of
/// std::filesystem that nobody caught counts as a ResourceError; its message names the path. So does an answer on
/// stdout that cannot be written, and a thread that the system refuses.
int run_guarded(const char* program, int (*body)(int, char**), int argc, char** argv);

[[noreturn]] void assertion_failed(const char* file, int line, const char* expression, const std::string& message);

/// Asserts a promise of our own, in every build: THIXO_ASSERT(count >= 3, "particle {} has {} neighbours", i, count).
#define THIXO_ASSERT(expression, ...)                                                                            \
    do {                                                                                                         \
        if (!(expression)) ::thixo::assertion_failed(__FILE__, __LINE__, #expression, fmt::format(__VA_ARGS__)); \
    } while (false)

/// Installs handlers that only note SIGINT and SIGTERM; loops ask interrupted() at safe points. SIGXFSZ is ignored: a
/// write beyond the limit on file sizes (ulimit -f) then fails as on a full disk.
void catch_interrupts();
/// 0, or the number of the signal that arrived.
int interrupted();

}  // namespace thixo
