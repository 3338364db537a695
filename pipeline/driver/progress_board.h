// One progress display for several stages: their "@progress" lines in, one bar with the time left (terminal) or plain
// lines (piped) out.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace thixo {

/// A line "@progress <stage> <done> <total> <note>" (base/log.h).
struct ProgressReport {
    std::string stage;
    int done = 0, total = 0;
    std::string note;
};

/// Nothing where the line is none.
std::optional<ProgressReport> parse_progress(std::string_view line);

class ProgressBoard {
  public:
    /// `terminal`: redraw one line; else one line a report. `quiet`: nothing at all.
    ProgressBoard(bool terminal, bool quiet) : terminal_(terminal), quiet_(quiet) {}

    /// Takes a report that arrived at `now` [s] and returns the text to print.
    std::string update(const ProgressReport& report, double now);
    /// Text to print before another message, so that it stands on a line of its own; the next update draws the bar
    /// again.
    std::string interrupt();

  private:
    struct Stage {
        ProgressReport last;
        int first_done = 0;  // frames that were there before this run
        double first_time = 0;
    };
    double seconds_left(double now) const;

    std::vector<Stage> stages_;
    bool terminal_, quiet_;
    bool drawn_ = false;
};

}  // namespace thixo
