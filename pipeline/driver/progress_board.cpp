#include "pipeline/driver/progress_board.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "pipeline/base/log.h"

namespace thixo {
namespace {

constexpr std::string_view kMark = "@progress ";
constexpr int kBarWidth = 24;

std::string_view next_word(std::string_view& rest) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    const std::string_view word = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return word;
}

bool read_count(std::string_view word, int& value) {
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    return failure == std::errc() && end == word.data() + word.size() && value >= 0;
}

}  // namespace

std::optional<ProgressReport> parse_progress(std::string_view line) {
    if (!line.starts_with(kMark)) return {};
    line.remove_prefix(kMark.size());
    ProgressReport report;
    report.stage = next_word(line);
    if (!read_count(next_word(line), report.done) || !read_count(next_word(line), report.total)) return {};
    report.note = line;
    return report;
}

std::string ProgressBoard::update(const ProgressReport& report, double now) {
    auto stage = std::find_if(stages_.begin(), stages_.end(),
                              [&](const Stage& known) { return known.last.stage == report.stage; });
    if (stage == stages_.end()) stage = stages_.insert(stages_.end(), {report, report.done, now});
    stage->last = report;
    if (quiet_) return {};
    const double left = seconds_left(now);
    const std::string time = left < 0 ? "" : fmt::format("  {} left", clock_text(left));
    if (!terminal_) return fmt::format("{} {}/{}  {}{}\n", report.stage, report.done, report.total, report.note, time);

    // The bar shows the stage that is furthest behind; the others stand beside it as numbers.
    const auto share = [](const Stage& running) {
        return running.last.total > 0 ? std::min(1.0, double(running.last.done) / running.last.total) : 1.0;
    };
    double least = 1;
    std::string counts;
    for (const Stage& running : stages_) {
        least = std::min(least, share(running));
        counts += fmt::format("{}{} {}/{}", counts.empty() ? "" : ", ", running.last.stage, running.last.done,
                              running.last.total);
    }
    const int full = static_cast<int>(kBarWidth * least);
    drawn_ = true;
    return fmt::format("\r\033[K[{}{}] {}{}  {}", std::string(full, '#'), std::string(kBarWidth - full, '.'), counts,
                       time, report.note);
}

std::string ProgressBoard::interrupt() {
    const bool clear = drawn_;
    drawn_ = false;
    return clear ? "\n" : "";
}

// The stages run side by side and share the cores. So the time left is that of the slowest stage, at its own pace [s].
// It is -1 while no stage has a pace.
double ProgressBoard::seconds_left(double now) const {
    double left = -1;
    for (const Stage& stage : stages_) {
        const int made = stage.last.done - stage.first_done;
        if (made > 0) left = std::max(left, (now - stage.first_time) / made * (stage.last.total - stage.last.done));
    }
    return left;
}

}  // namespace thixo
