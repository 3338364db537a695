// The list of shortfalls from and to JSON. Only .cpp files that parse or print JSON include this.
#pragma once

#include <string>
#include <vector>

#include "pipeline/contract/json_fields.h"
#include "pipeline/contract/shortfall.h"

namespace thixo {

/// [{"kind", "name", "count", "of", "worst", "text"}]: as in frame.NNNN.json and in answers. Reading leaves the text
/// alone and throws CacheError; `file` is named in messages.
Json shortfalls_json(const std::vector<Shortfall>& list);
std::vector<Shortfall> parse_shortfalls(const Json& json, const std::string& file);

}  // namespace thixo
