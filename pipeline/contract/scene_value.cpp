#include "pipeline/contract/scene_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "pipeline/contract/scene_shapes.h"

namespace thixo::scene {
namespace {

bool plain(const std::string& text) {
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    if (text.empty() || !letter(text[0])) return false;
    if (!std::all_of(text.begin(), text.end(), [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; }))
        return false;
    // Words that YAML readers take for truth values or nothing.
    static constexpr std::string_view taken[] = {"true", "false", "yes", "no", "on", "off", "y", "n", "null"};
    std::string lower = text;
    for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return std::find(std::begin(taken), std::end(taken), lower) == std::end(taken);
}

std::string scalar_text(const Value& value) {
    if (!value.quoted || plain(value.text)) return value.text;
    std::string out = "\"";
    for (const char c : value.text) {
        if (c == '"' || c == '\\')
            out += fmt::format("\\{}", c);
        else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
        else
            out += c;
    }
    return out + "\"";
}

std::string label_text(const Label& label) {
    Value v;
    v.text = label.text;
    v.quoted = true;
    return scalar_text(v);
}

bool of_scalars(const Value& value) {
    return std::all_of(value.items.begin(), value.items.end(),
                       [](const Value& v) { return v.type == Value::Type::scalar; });
}

// Lists of numbers, lists of such lists, and the entries of a motion fit into a line.
bool flat(const Value& value) {
    if (value.items.empty()) return true;
    return value.type == Value::Type::list && of_scalars(value);
}

std::string flow(const Value& value) {
    if (value.type == Value::Type::scalar) return scalar_text(value);
    if (value.type == Value::Type::null) return "~";
    std::string out(1, value.type == Value::Type::list ? '[' : '{');
    for (std::size_t k = 0; k < value.items.size(); ++k) {
        if (k > 0) out += ", ";
        if (value.type == Value::Type::map) out += label_text(value.labels[k]) + ": ";
        out += flow(value.items[k]);
    }
    return out + (value.type == Value::Type::list ? ']' : '}');
}

// Appends the value that follows a "key:" or "-" already in `out`; nested lines are indented by `indent` blanks.
void block(const Value& value, int indent, bool in_list, std::string& out) {
    if (value.type == Value::Type::scalar || value.type == Value::Type::null || flat(value)) {
        out += " " + flow(value) + "\n";
        return;
    }
    const std::string blanks(static_cast<std::size_t>(indent), ' ');
    bool first = in_list && value.type == Value::Type::map;  // the first key stands behind the dash
    if (!first) out += "\n";
    for (std::size_t k = 0; k < value.items.size(); ++k) {
        out += first ? " " : blanks;
        first = false;
        if (value.type == Value::Type::map) {
            out += label_text(value.labels[k]) + ":";
            block(value.items[k], indent + 2, false, out);
        } else {
            out += "-";
            block(value.items[k], indent + 2, true, out);
        }
    }
}

// True where the labels lead to a shape: the value of a key `shape`, or an entry of the top-level block `shapes`.
bool is_shape(const std::vector<std::string>& path) {
    if (path.empty()) return false;
    return path.back() == "shape" || (path.size() == 2 && path[0] == "shapes");
}

// True where the labels lead to a light: of a scene, or of a look file that holds a look's keys directly.
bool is_light(const std::vector<std::string>& path) {
    return (path.size() == 3 && path[0] == "look" && path[1] == "lights") || (path.size() == 2 && path[0] == "lights");
}

void remove_shape_kinds(Value& base, const Value& over) {
    bool named = false;
    for_each_shape_kind([&](const auto& kind) { named = named || over.find(kind.name); });
    if (!named) return;
    for_each_shape_kind([&](const auto& kind) {
        if (!over.find(kind.name)) base.remove(kind.name);
    });
}

}  // namespace

const Value* Value::find(std::string_view label) const {
    for (std::size_t k = 0; k < labels.size(); ++k)
        if (labels[k].text == label) return &items[k];
    return nullptr;
}

Value* Value::find(std::string_view label) { return const_cast<Value*>(static_cast<const Value*>(this)->find(label)); }

Value& Value::at_label(const Label& label) {
    if (Value* found = find(label.text)) return *found;
    type = Type::map;
    labels.push_back(label);
    items.emplace_back();
    items.back().at = label.at;
    return items.back();
}

void Value::remove(std::string_view label) {
    for (std::size_t k = 0; k < labels.size(); ++k) {
        if (labels[k].text != label) continue;
        labels.erase(labels.begin() + static_cast<std::ptrdiff_t>(k));
        items.erase(items.begin() + static_cast<std::ptrdiff_t>(k));
        return;
    }
}

std::string describe(const Value& value) {
    switch (value.type) {
        case Value::Type::null:
            return "nothing";
        case Value::Type::list:
            return "a list";
        case Value::Type::map:
            return "a block";
        case Value::Type::scalar:
            break;
    }
    return value.quoted ? fmt::format("the text \"{}\"", shown(value.text)) : fmt::format("\"{}\"", shown(value.text));
}

std::string print_value(const Value& value) {
    std::string out;
    if (value.type != Value::Type::map || value.items.empty()) return flow(value) + "\n";
    for (std::size_t k = 0; k < value.items.size(); ++k) {
        out += label_text(value.labels[k]) + ":";
        block(value.items[k], 2, false, out);
    }
    return out;
}

void make_room(Value& block, std::string_view key, const std::vector<std::string>& path) {
    if (!is_light(path)) return;
    if (key == "look_at") block.remove("direction");
    if (key == "direction") block.remove("look_at");
}

void overlay(Value& base, const Value& over, std::vector<std::string>& path) {
    if (base.type != Value::Type::map || over.type != Value::Type::map) {
        // A block written with nothing in it changes nothing.
        if (base.type != Value::Type::map || over.type != Value::Type::null) base = over;
        return;
    }
    if (is_shape(path)) remove_shape_kinds(base, over);
    for (const Label& label : over.labels) make_room(base, label.text, path);
    std::unordered_map<std::string_view, std::size_t> known;
    for (std::size_t k = 0; k < base.labels.size(); ++k) known.emplace(base.labels[k].text, k);
    std::vector<std::size_t> added;
    for (std::size_t k = 0; k < over.labels.size(); ++k) {
        const auto found = known.find(over.labels[k].text);
        if (found == known.end()) {
            added.push_back(k);
            continue;
        }
        path.push_back(over.labels[k].text);
        overlay(base.items[found->second], over.items[k], path);
        path.pop_back();
    }
    for (const std::size_t k : added) {
        base.labels.push_back(over.labels[k]);
        base.items.push_back(over.items[k]);
    }
}

}  // namespace thixo::scene
