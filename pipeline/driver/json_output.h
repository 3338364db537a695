// What verbs print with --json.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace thixo {

/// One line on the standard output. Bytes of paths that are no UTF-8 become U+FFFD; those of the command line itself
/// are refused before the work (parse_command).
void print_json(const nlohmann::ordered_json& value);

}  // namespace thixo
