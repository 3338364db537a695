#include "pipeline/driver/fell_short.h"

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/cache_shortfalls.h"

namespace thixo {

int tell_shortfalls(const std::vector<Shortfall>& list, const Command& command) {
    for (const Shortfall& s : list) log_warning("{}", shortfall_text(s));
    return command.strict && !list.empty() ? kFellShort : int(kDone);
}

std::vector<Shortfall> shortfalls_in(const std::filesystem::path& out) {
    return CacheReader::exists(out) ? shortfalls_of(CacheReader(out)) : std::vector<Shortfall>();
}

}  // namespace thixo
