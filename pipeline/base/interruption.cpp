#include "pipeline/base/interruption.h"

#include <fmt/core.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/printable.h"

namespace thixo {
namespace {
constexpr int kLook = 100, kGrace = 1000;  // ms: between two looks at the signal; that the work has to end by itself
}

InterruptionWatch::InterruptionWatch(const char* program, std::function<void()> save)
    : program_(program), save_(std::move(save)), thread_([this] { watch(); }) {}

InterruptionWatch::~InterruptionWatch() {
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    ended_.notify_all();
    thread_.join();
}

bool InterruptionWatch::over_within(int milliseconds) {
    std::unique_lock lock(mutex_);
    return ended_.wait_for(lock, std::chrono::milliseconds(milliseconds), [this] { return over_; });
}

void InterruptionWatch::watch() {
    while (interrupted() == 0)
        if (over_within(kLook)) return;
    if (over_within(kGrace)) return;
    const InterruptedError answer(interrupted());
    std::string said = answer.what();
    int code = answer.code();
    try {
        save_();
    } catch (const Error& e) {
        said = e.what();
        code = e.code();
    } catch (const std::exception& e) {  // of the system: memory, files
        said = e.what();
        code = kNoResource;
    }
    if (over_within(0)) return;  // the work has ended meanwhile, and tells it
    fmt::print(stderr, "{}: {}\n", program_, printable(said));
    std::fflush(stdout);
    std::_Exit(code);
}

}  // namespace thixo
