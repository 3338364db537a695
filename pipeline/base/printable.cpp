#include "pipeline/base/printable.h"

#include <fmt/core.h>

namespace thixo {

std::string printable(std::string_view text) {
    std::string shown;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
        const bool control = (c < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
        const bool control_of_unicode = c == 0xc2 && next >= 0x80 && next < 0xa0;
        if (control || control_of_unicode)
            shown += fmt::format("\\x{:02x}", control ? c : next);
        else
            shown += text[i];
        if (control_of_unicode) ++i;
    }
    return shown;
}

}  // namespace thixo
