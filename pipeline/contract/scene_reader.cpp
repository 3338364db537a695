#include "pipeline/contract/scene_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "pipeline/contract/scene_reach.h"
#include "pipeline/contract/scene_scalar.h"

namespace thixo::scene {

bool is_name(std::string_view text) {
    const auto word = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    };
    return !text.empty() && text.size() <= 64 && word(text[0]) &&
           std::all_of(text.begin(), text.end(), [&](char c) { return word(c) || c == '-'; });
}

std::string describe(const Check& check) {
    const Check free = any();
    if (check.nonzero) return "not all 0";
    if (check.low == free.low && check.high == free.high) return {};
    const std::string low = fmt::format("{} {}", check.open_low ? "above" : "at least", check.low);
    const std::string high = fmt::format("{} {}", check.open_high ? "below" : "at most", check.high);
    if (check.high == free.high) return low;
    if (check.low == free.low) return high;
    return check.open_low || check.open_high ? low + ", " + high : fmt::format("{} to {}", check.low, check.high);
}

BlockReader::BlockReader(const Value& map, std::string path, const Position& at, ReadContext& context)
    : map_(map), path_(std::move(path)), at_(at), context_(context) {
    if (!path_.empty()) context_.where[path_] = at;
}

// The value of a key, or nothing where it is left out; notes that the key is known, and where it stands.
const Value* BlockReader::take(const char* name, Check check) {
    known_.emplace_back(name);
    const Value* value = map_.find(name);
    if (value)
        context_.where[child(name)] = value->at;
    else if (check.required)
        context_.problems.add(at_, fmt::format("{} needs the key \"{}\"", path_.empty() ? "the scene" : path_, name));
    return value;
}

void BlockReader::wrong_type(const Value& value, std::string_view name, const char* wanted) {
    context_.problems.add(value.at, fmt::format("\"{}\" needs {}, not {}", name, wanted, describe(value)));
}

bool BlockReader::is_block(const Value& value, std::string_view name) {
    if (value.type == Value::Type::map || value.type == Value::Type::null) return true;
    if (value.type == Value::Type::scalar && value.text.find(':') != std::string::npos && !value.quoted)
        context_.problems.add(value.at, fmt::format("\"{}\" needs a block of keys, not {}", name, describe(value)),
                              "a blank is missing behind the colon");
    else
        wrong_type(value, name, "a block of keys");
    return false;
}

bool BlockReader::is_list(const Value& value, std::string_view name) {
    if (value.type == Value::Type::list) return true;
    wrong_type(value, name, "a list");
    return false;
}

bool BlockReader::in_range(const Value& value, std::string_view name, const char* unit, Check check, double number) {
    const bool low = check.open_low ? number > check.low : number >= check.low;
    const bool high = check.open_high ? number < check.high : number <= check.high;
    if (low && high) return true;
    const bool has_unit = *unit && unit != std::string_view("1") && unit != std::string_view(kColour);
    // An end that is not written is told where it is the one that is passed.
    const bool past_hidden = (!low && check.low == any().low) || (!high && check.high == any().high);
    const std::string range = past_hidden ? fmt::format("{} to {}", check.low, check.high) : describe(check);
    context_.problems.add(value.at, fmt::format("\"{}\" must be {}{}{}, not {}", name, range, has_unit ? " " : "",
                                                has_unit ? unit : "", shown(value.text)));
    return false;
}

bool BlockReader::number(const Value& value, std::string_view name, const char* unit, Check check, double& result) {
    const Scalar<double> scalar = to_number(value);
    if (!scalar.value) {
        context_.problems.add(value.at, fmt::format("\"{}\" needs a number, not {}", name, describe(value)),
                              scalar.hint);
        return false;
    }
    if (!in_range(value, name, unit, check, *scalar.value)) return false;
    result = *scalar.value;
    return true;
}

bool BlockReader::numbers(const Value& value, std::string_view name, const char* unit, Check check, int count,
                          const char* form, double* result) {
    if (value.type != Value::Type::list) {
        context_.problems.add(value.at,
                              fmt::format("\"{}\" needs {} numbers {}, not {}", name, count, form, describe(value)));
        return false;
    }
    if (value.items.size() != static_cast<std::size_t>(count)) {
        context_.problems.add(value.at,
                              fmt::format("\"{}\" needs {} numbers {}, not {}", name, count, form, value.items.size()));
        return false;
    }
    bool good = true;
    for (int k = 0; k < count; ++k)
        good = number(value.items[static_cast<std::size_t>(k)], name, unit, check, result[k]) && good;
    return good;
}

void BlockReader::key(const char* name, double& member, const char* unit, Check check, const char*) {
    if (const Value* value = take(name, check)) number(*value, name, unit, check, member);
}

void BlockReader::key(const char* name, int& member, const char* unit, Check check, const char*) {
    const Value* value = take(name, check);
    if (!value) return;
    const Scalar<std::int64_t> scalar = to_whole(*value);
    if (!scalar.value)
        context_.problems.add(value->at, fmt::format("\"{}\" needs a whole number, not {}", name, describe(*value)),
                              scalar.hint);
    else if (in_range(*value, name, unit, check, static_cast<double>(*scalar.value)))
        member = static_cast<int>(std::clamp<std::int64_t>(*scalar.value, INT32_MIN, INT32_MAX));
}

void BlockReader::key(const char* name, std::uint64_t& member, const char*, Check check, const char*) {
    const Value* value = take(name, check);
    if (!value) return;
    const Scalar<std::uint64_t> scalar = to_unsigned(*value);
    if (scalar.value)
        member = *scalar.value;
    else
        context_.problems.add(value->at,
                              fmt::format("\"{}\" needs a whole number of at least 0, not {}", name, describe(*value)),
                              scalar.hint);
}

void BlockReader::key(const char* name, bool& member, const char*, Check check, const char*) {
    const Value* value = take(name, check);
    if (!value) return;
    const Scalar<bool> scalar = to_truth(*value);
    if (scalar.value)
        member = *scalar.value;
    else
        context_.problems.add(value->at, fmt::format("\"{}\" needs true or false, not {}", name, describe(*value)),
                              scalar.hint);
}

void BlockReader::key(const char* name, std::string& member, const char*, Check check, const char*) {
    const Value* value = take(name, check);
    if (!value) return;
    if (value->type != Value::Type::scalar)
        wrong_type(*value, name, "a text");
    else if (value->text.size() > 1000)
        context_.problems.add(value->at, fmt::format("\"{}\" has more than 1000 bytes", name));
    else
        member = value->text;
}

void BlockReader::key(const char* name, Vec2d& member, const char* unit, Check check, const char*) {
    double v[2];
    if (const Value* value = take(name, check))
        if (numbers(*value, name, unit, check, 2, "[x, y]", v)) member = Vec2d(v[0], v[1]);
}

void BlockReader::key(const char* name, Vec3d& member, const char* unit, Check check, const char*) {
    const Value* value = take(name, check);
    double v[3];
    if (!value ||
        !numbers(*value, name, unit, check, 3, unit == std::string_view(kColour) ? "[r, g, b]" : "[x, y, z]", v))
        return;
    if (check.nonzero && !(Vec3d(v[0], v[1], v[2]).norm() > 1e-9))
        context_.problems.add(value->at, fmt::format("\"{}\" must point somewhere, not be [0, 0, 0]", name));
    else
        member = Vec3d(v[0], v[1], v[2]);
}

void BlockReader::key(const char* name, std::optional<Vec3d>& member, const char* unit, Check check,
                      const char* meaning) {
    if (!map_.find(name)) {
        take(name, check);
        return;
    }
    Vec3d v = member.value_or(Vec3d::Ones());
    key(name, v, unit, check, meaning);
    member = v;
}

void BlockReader::key(const char* name, std::vector<Vec2d>& member, const char* unit, Check check, const char*) {
    const Value* value = take(name, check);
    if (!value || !is_list(*value, name)) return;
    std::vector<Vec2d> points;
    bool good = true;
    for (const Value& item : value->items) {
        double v[2] = {0, 0};
        good = numbers(item, name, unit, check, 2, "[r, z]", v) && good;
        points.emplace_back(v[0], v[1]);
    }
    if (good) member = std::move(points);
}

int BlockReader::word(const char* name, const std::vector<std::string>& words, Check check) {
    const Value* value = take(name, check);
    if (!value) return -1;
    const auto found =
        value->type == Value::Type::scalar ? std::find(words.begin(), words.end(), value->text) : words.end();
    if (found != words.end()) return static_cast<int>(found - words.begin());
    const std::string hint = value->type == Value::Type::scalar ? nearest_word(value->text, words) : "";
    context_.problems.add(
        value->at, fmt::format("\"{}\" must be one of {}, not {}", name, fmt::join(words, ", "), describe(*value)),
        hint.empty() ? "" : fmt::format("did you mean \"{}\"?", hint));
    return -1;
}

void BlockReader::reference(const char* name, std::string& member, Refers, Check check, const char*) {
    const Value* value = take(name, check);
    if (!value) return;
    if (value->type != Value::Type::scalar)
        wrong_type(*value, name, "a name");
    else if (value->text.empty() ? check.required : !is_name(value->text))
        context_.problems.add(value->at, fmt::format("\"{}\" needs a name, not {}", name, describe(*value)));
    else
        member = value->text;
}

void BlockReader::file(const char* name, std::string& member, Check check, const char*) {
    const Value* value = take(name, check);
    if (!value) return;
    if (value->type != Value::Type::scalar || (value->text.empty() && (check.required || !value->quoted)) ||
        value->text.size() > 4000) {
        wrong_type(*value, name, "the path of a file");
        return;
    }
    member = value->text;
    if (member.empty()) return;  // none
    if (context_.files == Files::ignore || value->at.source < 0) return;
    namespace fs = std::filesystem;
    member = (fs::path(context_.problems.source(value->at.source).folder) / value->text).lexically_normal().string();
    if (!may_open(member, value->at, context_.problems)) context_.closed.insert(member);
}

void BlockReader::report_unknown(const char* also) {
    std::vector<std::string> suggested = known_;
    if (also) suggested.emplace_back(also);
    for (const Label& label : map_.labels) {
        if (std::find(known_.begin(), known_.end(), label.text) != known_.end()) continue;
        const bool joined = label.text.find(':') != std::string::npos;
        context_.problems.add(
            label.at, fmt::format("unknown key \"{}\" in {}", shown(label.text), path_.empty() ? "the scene" : path_),
            joined ? "a blank is missing behind the colon" : suggestion(label.text, suggested));
    }
}

bool BlockReader::entry_is_sound(const Value& map, std::size_t k, const char* block) {
    const Label& label = map.labels[k];
    if (!is_name(label.text)) {
        context_.problems.add(label.at, fmt::format("\"{}\" is no name", shown(label.text)),
                              "letters, digits, _ and -, at most 64");
        return false;
    }
    if (label.at.source >= 0 &&
        context_.problems.source(label.at.source).is_override) {  // a misspelled name would add an entry
        std::vector<std::string> names;
        for (const Label& other : map.labels)
            if (other.text != label.text) names.push_back(other.text);
        context_.problems.add(label.at, fmt::format("there is no \"{}\" in {}", label.text, child(block)),
                              suggestion(label.text, names));
        return false;
    }
    return is_block(map.items[k], label.text);
}

}  // namespace thixo::scene
