// Files with one line a frame. A run that continues keeps their beginning.
#pragma once

#include <cstdlib>
#include <istream>
#include <string>
#include <string_view>

namespace thixo {

/// The lines from here on that begin with `lead` and the number of a frame up to `last`. A line cut short by a kill has
/// no end of line, and is left out.
inline std::string lines_of_frames(std::istream& file, std::string_view lead, int last) {
    std::string lines;
    for (std::string line; std::getline(file, line) && !file.eof();)
        if (line.starts_with(lead) && std::atoi(line.c_str() + lead.size()) <= last) lines += line + "\n";
    return lines;
}

}  // namespace thixo
