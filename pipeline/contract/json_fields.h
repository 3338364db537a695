// Checked access to JSON for the files of a cache. Only .cpp files that parse or print JSON include this.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace thixo {

using Json = nlohmann::ordered_json;

/// Where a value stands, for messages: a file and the path of keys within it.
struct JsonPlace {
    std::string file, path;
    JsonPlace in(const std::string& key) const { return {file, path.empty() ? key : path + "." + key}; }
};

/// All throw CacheError naming the place: not JSON, nested too deep, no such key, another type, out of range, not
/// finite.
Json parse_json(std::string_view text, const std::string& file);
const Json& object_or_fail(const Json& value, const JsonPlace& place);
const Json& array_at(const Json& object, const char* key, const JsonPlace& place);
const Json& object_at(const Json& object, const char* key, const JsonPlace& place);
std::string text_at(const Json& object, const char* key, const JsonPlace& place);
bool bool_at(const Json& object, const char* key, const JsonPlace& place);
double number_at(const Json& object, const char* key, const JsonPlace& place);
std::int64_t integer_at(const Json& object, const char* key, std::int64_t least, std::int64_t most,
                        const JsonPlace& place);
/// Fills out[0..count) from an array of exactly so many finite numbers.
void numbers_at(const Json& object, const char* key, double* out, std::size_t count, const JsonPlace& place);
template <std::size_t N>
std::array<double, N> numbers_at(const Json& object, const char* key, const JsonPlace& place) {
    std::array<double, N> out;
    numbers_at(object, key, out.data(), N, place);
    return out;
}

/// Two-space indented text with a final newline. Throws InputError where a string is not UTF-8; `what` is named.
std::string print_json(const Json& value, const std::string& what);

}  // namespace thixo
