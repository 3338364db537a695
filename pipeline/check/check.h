// A whole check: two paths in, a report out.
#pragma once

#include "pipeline/base/error.h"
#include "pipeline/check/report.h"
#include "pipeline/contract/check_args.h"

namespace thixo {

/// Compares args.path with args.against, writes difference pictures where args.diff names a folder, and with
/// args.update makes A the reference (never from files that are damaged or hold values that are not finite). A damaged
/// file is reported with its frame and the rest compared. Throws InputError (the two are not of a sort, bad frame
/// range) and CacheError (nothing there, or no such frames).
CheckReport check(const CheckArgs& args);

/// 0 same or updated, 1 different, 4 damaged.
ExitCode exit_code_of(const CheckReport& report);

}  // namespace thixo
