#include "pipeline/contract/json_fields.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"

namespace thixo {
namespace {

[[noreturn]] void wrong(const JsonPlace& place, const char* wanted) {
    throw CacheError("'{}' is damaged: \"{}\" is not {}", place.file, place.path, wanted);
}

const Json& at(const Json& object, const char* key, const JsonPlace& place) {
    const auto it = object.find(key);
    if (it == object.end()) throw CacheError("'{}' is damaged: it has no \"{}\"", place.file, place.in(key).path);
    return *it;
}

double finite(const Json& value, const JsonPlace& place) {
    if (!value.is_number()) wrong(place, "a number");
    const double number = value.get<double>();
    if (!std::isfinite(number)) wrong(place, "finite");
    return number;
}

/// Each level of nesting costs the parser far more memory than the byte that opens it.
void require_shallow(std::string_view text, const std::string& file) {
    constexpr int kDeepest = 256;
    int depth = 0;
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted && c == '\\')
            ++i;
        else if (c == '"')
            quoted = !quoted;
        else if (!quoted && (c == '[' || c == '{') && ++depth > kDeepest)
            throw CacheError("'{}' is damaged: it is nested more than {} deep", file, kDeepest);
        else if (!quoted && (c == ']' || c == '}'))
            --depth;
    }
}

}  // namespace

Json parse_json(std::string_view text, const std::string& file) {
    require_shallow(text, file);
    try {
        return Json::parse(text.begin(), text.end());
    } catch (const nlohmann::json::exception& e) {
        throw CacheError("'{}' is damaged: it is not JSON", file);
    }
}

const Json& object_or_fail(const Json& value, const JsonPlace& place) {
    if (!value.is_object()) wrong(place, "an object");
    return value;
}

const Json& array_at(const Json& object, const char* key, const JsonPlace& place) {
    const Json& value = at(object, key, place);
    if (!value.is_array()) wrong(place.in(key), "a list");
    return value;
}

const Json& object_at(const Json& object, const char* key, const JsonPlace& place) {
    return object_or_fail(at(object, key, place), place.in(key));
}

std::string text_at(const Json& object, const char* key, const JsonPlace& place) {
    const Json& value = at(object, key, place);
    if (!value.is_string()) wrong(place.in(key), "a text");
    return value.get<std::string>();
}

bool bool_at(const Json& object, const char* key, const JsonPlace& place) {
    const Json& value = at(object, key, place);
    if (!value.is_boolean()) wrong(place.in(key), "true or false");
    return value.get<bool>();
}

double number_at(const Json& object, const char* key, const JsonPlace& place) {
    return finite(at(object, key, place), place.in(key));
}

std::int64_t integer_at(const Json& object, const char* key, std::int64_t least, std::int64_t most,
                        const JsonPlace& place) {
    const Json& value = at(object, key, place);
    if (!value.is_number_integer()) wrong(place.in(key), "an integer");
    if (value.is_number_unsigned() && value.get<std::uint64_t>() > static_cast<std::uint64_t>(INT64_MAX))
        wrong(place.in(key), "in range");
    const auto number = value.get<std::int64_t>();
    if (number < least || number > most) wrong(place.in(key), "in range");
    return number;
}

void numbers_at(const Json& object, const char* key, double* out, std::size_t count, const JsonPlace& place) {
    const Json& list = array_at(object, key, place);
    if (list.size() != count) wrong(place.in(key), "a list of the right length");
    for (std::size_t i = 0; i < count; ++i) out[i] = finite(list[i], place.in(key));
}

std::string print_json(const Json& value, const std::string& what) {
    try {
        return value.dump(2) + "\n";
    } catch (const nlohmann::json::exception&) {
        throw InputError("{}: a text is not UTF-8; write the scene in UTF-8", what);
    }
}

}  // namespace thixo
