// Text from files on its way to a terminal.
#pragma once

#include <string>
#include <string_view>

namespace thixo {

/// The text with every control character but the end of a line and the tab written as \xNN: names that come from files
/// must not steer a terminal.
std::string printable(std::string_view text);

}  // namespace thixo
