#include "pipeline/contract/machine_memory.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/sysinfo.h>

#include <algorithm>
#include <limits>

#include "pipeline/base/error.h"

namespace thixo {

double machine_memory() {
    double memory = std::numeric_limits<double>::infinity();
    struct sysinfo info {};
    if (::sysinfo(&info) == 0)
        memory = (static_cast<double>(info.totalram) + static_cast<double>(info.totalswap)) * info.mem_unit;
    rlimit limit{};
    if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
        memory = std::min(memory, static_cast<double>(limit.rlim_cur));
    return memory;
}

std::string bytes_text(double bytes) {
    return bytes < 1e6   ? fmt::format("{:.0f} kB", bytes / 1e3)
           : bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6)
                         : fmt::format("{:.1f} GB", bytes / 1e9);
}

void require_memory(double needed, const std::string& what, const std::string& remedy) {
    const double there = machine_memory();
    if (needed > there)
        throw ResourceError("{} needs about {} of memory, this machine has {}; {}", what, bytes_text(needed),
                            bytes_text(there), remedy);
}

}  // namespace thixo
