// Makes text from files safe for a terminal.
#pragma once

#include <string>
#include <string_view>

namespace thixo {

/// The text with control characters written as \xNN, except tabs and ends of lines. Names from files must not control a
/// terminal.
std::string printable(std::string_view text);

}  // namespace thixo
