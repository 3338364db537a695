// Messages to a person, on stderr; results a program reads go to stdout.
#pragma once

#include <fmt/core.h>

#include <optional>
#include <string>

namespace thixo {

/// Sets how much is said: quiet keeps warnings and errors only.
void set_quiet(bool quiet);

void log_line(const char* level, const std::string& text);

template <class... A>
void log_info(fmt::format_string<A...> f, A&&... a) {
    log_line("", fmt::format(f, std::forward<A>(a)...));
}
template <class... A>
void log_warning(fmt::format_string<A...> f, A&&... a) {
    log_line("warning: ", fmt::format(f, std::forward<A>(a)...));
}

/// 0:07, 12:34, 1:02:03
std::string clock_text(double seconds);

/// Progress of one stage: a bar with the remaining time on a terminal, one plain line per frame when piped. The driver
/// starts its stages with `machine` set. They then print lines that the driver turns into its own bar:
///     @progress <stage> <done> <total> <note>
class Progress {
  public:
    Progress(std::string stage, int total, bool machine = false);
    /// The first update says how many frames existed before the work began. Later ones estimate the remaining time from
    /// the frames that were made since.
    void update(int done, const std::string& note);
    void finish();

  private:
    std::string stage_;
    int total_;
    bool machine_;
    bool terminal_;
    struct Start {
        int done;
        double time;  // s
    };
    std::optional<Start> start_;
};

}  // namespace thixo
