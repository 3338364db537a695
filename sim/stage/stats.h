// stats.jsonl: the cost and quality of a run, one line a frame. Times stand here and nowhere else.
#pragma once

#include <filesystem>

#include "pipeline/contract/frame.h"
#include "sim/loop/simulation.h"

namespace thixo {

/// Keeps the lines of out/stats.jsonl of frames up to `frame`, after which a run continues.
void begin_stats_file(const std::filesystem::path& out, int frame);

/// Appends one JSON object to out/stats.jsonl: frame, counts, steps, dt, the limit that set it, seconds by part,
/// density error, surface report. A line that cannot be written is a warning: the run does not depend on it.
void append_stats(const std::filesystem::path& out, const Simulation& sim, const FrameTotals& totals, double seconds);

}  // namespace thixo
