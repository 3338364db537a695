// A whole check: two paths in, a report out.
#pragma once

#include "pipeline/base/error.h"
#include "pipeline/check/report.h"
#include "pipeline/contract/check_args.h"

namespace thixo {

/// Compares A = args.path with the reference args.against. Writes difference pictures where args.diff names a folder.
/// With args.update A becomes the reference, unless its files are damaged or hold values that are not finite. A damaged
/// file is reported with its frame, and the other frames are still compared. Throws InputError (the two are not of one
/// sort, bad frame range) and CacheError (nothing there, no such frames).
CheckReport check(const CheckArgs& args);

/// 0: same or updated; 1: different; 4: damaged.
ExitCode exit_code_of(const CheckReport& report);

}  // namespace thixo
