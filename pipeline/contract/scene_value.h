// A YAML document as a plain tree: what files, overrides and printed scenes are turned into before anything is read
// from them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pipeline/contract/scene_problems.h"

namespace thixo::scene {

struct Label {  // a key of a map
    std::string text;
    Position at;
};

struct Value {
    enum class Type { null, scalar, list, map };
    Type type = Type::null;
    bool quoted = false;        // scalar in quotes: text, whatever it looks like
    std::string text;           // scalar
    std::vector<Value> items;   // list; or the values of a map
    std::vector<Label> labels;  // map: as many as items, no two the same
    Position at;

    const Value* find(std::string_view label) const;
    Value* find(std::string_view label);
    /// The item of that label, added where there is none (turns a null into a map). Requires a null or a map.
    Value& at_label(const Label& label);
    void remove(std::string_view label);
};

/// What it is, for messages: the text "abc", a list, a block, nothing.
std::string describe(const Value& value);

/// The tree as YAML text in block style, ending with a line end; short lists in one line.
std::string print_value(const Value& value);

/// Lays `over` over `base`: maps merge key by key, everything else replaces. In a shape another kind replaces the kind,
/// and of a light one of `look_at` and `direction` the other. `path` holds the labels that lead to it.
void overlay(Value& base, const Value& over, std::vector<std::string>& path);

/// Removes the key of a light, if `path` leads to one, that this key takes the place of.
void make_room(Value& block, std::string_view key, const std::vector<std::string>& path);

}  // namespace thixo::scene
