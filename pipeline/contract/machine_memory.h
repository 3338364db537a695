// The memory there is for what a run will need.
#pragma once

#include <string>

namespace thixo {

/// Memory and swap of this machine, or what this process may have of it [bytes].
double machine_memory();

/// "60 MB", "5.1 GB".
std::string bytes_text(double bytes);

/// Throws ResourceError where `needed` [bytes] is more than the machine has: told before the work, not by the system in
/// the middle of it. `what` needs it, `remedy` is what the user may do.
void require_memory(double needed, const std::string& what, const std::string& remedy);

}  // namespace thixo
