#include "pipeline/base/log.h"

#include <unistd.h>

#include <atomic>
#include <cstdio>

#include "pipeline/base/printable.h"
#include "pipeline/base/timer.h"

namespace thixo {
namespace {
std::atomic<bool> quiet_mode{false};
}  // namespace

std::string clock_text(double seconds) {
    const int whole = static_cast<int>(seconds + 0.5);
    return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                        : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

void set_quiet(bool quiet) { quiet_mode = quiet; }

void log_line(const char* level, const std::string& text) {
    if (quiet_mode && *level == '\0') return;
    const std::string line = fmt::format("{}{}\n", level, printable(text));
    std::fwrite(line.data(), 1, line.size(), stderr);  // one write, so that lines of two processes do not mix
}

Progress::Progress(std::string stage, int total, bool machine)
    : stage_(std::move(stage)), total_(total), machine_(machine), terminal_(isatty(STDERR_FILENO) != 0) {}

void Progress::update(int done, const std::string& note) {
    if (machine_) {
        const std::string line = fmt::format("@progress {} {} {} {}\n", stage_, done, total_, note);
        std::fwrite(line.data(), 1, line.size(), stderr);
        return;
    }
    if (quiet_mode) return;
    if (!start_) start_ = Start{done, wall_seconds()};
    const int made = done - start_->done;
    const std::string left =
        made > 0 ? fmt::format("  {} left", clock_text((wall_seconds() - start_->time) / made * (total_ - done))) : "";
    if (terminal_) {
        const int width = 30, full = total_ > 0 ? width * done / total_ : width;
        const std::string line = fmt::format("\r\033[K{:<7} [{}{}] {}/{}{}  {}", stage_, std::string(full, '#'),
                                             std::string(width - full, '.'), done, total_, left, note);
        std::fwrite(line.data(), 1, line.size(), stderr);
    } else {
        log_line("", fmt::format("{} {}/{}  {}{}", stage_, done, total_, note, left));
    }
}

void Progress::finish() {
    if (terminal_ && !machine_ && !quiet_mode) std::fputc('\n', stderr);
}

}  // namespace thixo
