#include "pipeline/contract/scene_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "pipeline/contract/scene_reach.h"
#include "pipeline/contract/scene_yaml.h"

namespace thixo::scene {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kLongestChain = 16;

// One file per name, however it is spelled.
std::string identity(const std::string& path) {
    std::error_code failure;
    const fs::path real = fs::weakly_canonical(path, failure);
    return failure ? path : real.string();
}

// The file a value `extends: file` means; nothing after a problem.
std::optional<std::string> extended_path(const Value& extends, const std::vector<std::string>& chain,
                                         Problems& problems) {
    if (extends.type != Value::Type::scalar || extends.text.empty()) {
        problems.add(extends.at, fmt::format("\"extends\" needs the path of a scene file, not {}", describe(extends)));
        return std::nullopt;
    }
    const std::string path =
        (fs::path(problems.source(extends.at.source).folder) / extends.text).lexically_normal().string();
    if (std::find(chain.begin(), chain.end(), identity(path)) != chain.end()) {
        problems.add(extends.at, fmt::format("{} extends itself", shown(path, kPathShown)),
                     "remove this line or name another file");
        return std::nullopt;
    }
    if (chain.size() >= kLongestChain) {
        problems.add(extends.at, fmt::format("more than {} scene files extend each other", kLongestChain));
        return std::nullopt;
    }
    if (!may_open(path, extends.at, problems)) return std::nullopt;
    return path;
}

std::optional<Value> read_chain(int source, std::vector<std::string>& chain, Problems& problems) {
    std::optional<Value> tree = read_yaml(source, problems);
    if (!tree) return tree;
    const Value* extends = tree->find("extends");
    if (!extends) return tree;
    const std::optional<std::string> path = extended_path(*extends, chain, problems);
    const Position at = extends->at;
    tree->remove("extends");
    if (!path) return std::nullopt;
    const std::optional<int> base_source = open_source(*path, at, problems);
    if (!base_source) return std::nullopt;
    chain.push_back(identity(*path));
    std::optional<Value> base = read_chain(*base_source, chain, problems);
    if (!base) return base;
    std::vector<std::string> labels;
    overlay(*base, *tree, labels);
    return base;
}

struct Step {
    std::string label;
    int column = 1;  // in the override's text
};

std::vector<Step> split_path(const std::string& text) {
    std::vector<Step> steps;
    std::size_t begin = 0;
    while (true) {
        const std::size_t end = std::min(text.find('.', begin), text.size());
        steps.push_back({text.substr(begin, end - begin), characters(std::string_view(text).substr(0, begin)) + 1});
        if (end == text.size()) return steps;
        begin = end + 1;
    }
}

// The place that a step of an override's path leads to from `value`; null after a problem.
Value* descend(Value& value, const Step& step, int source, Problems& problems) {
    const Position at{source, 1, step.column, characters(step.label)};
    if (step.label.empty()) {
        problems.add(at, "a part of the key path is empty", "write for example --set solver.spacing=0.01");
        return nullptr;
    }
    if (value.type == Value::Type::list) {
        std::size_t index = 0;
        const char* last = step.label.data() + step.label.size();
        const auto [end, failure] = std::from_chars(step.label.data(), last, index);
        if (failure != std::errc() || end != last || index >= value.items.size()) {
            problems.add(at, fmt::format("\"{}\" is no place in this list", shown(step.label)),
                         value.items.empty() ? "the list is empty" : fmt::format("0 to {}", value.items.size() - 1));
            return nullptr;
        }
        return &value.items[index];
    }
    if (value.type == Value::Type::scalar) {
        problems.add(at, fmt::format("there is no \"{}\" in the value {}", shown(step.label), describe(value)));
        return nullptr;
    }
    return &value.at_label({step.label, at});
}

}  // namespace

std::optional<Value> read_tree(int source, Problems& problems, bool follow) {
    if (!follow) return read_yaml(source, problems);
    std::vector<std::string> chain{identity(problems.source(source).name)};
    return read_chain(source, chain, problems);
}

std::optional<Value> read_tree_file(const std::string& path, Problems& problems) {
    const std::optional<int> source = open_source(path, {}, problems);
    return source ? read_tree(*source, problems) : std::nullopt;
}

void apply_override(Value& tree, const std::string& text, Problems& problems) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || text.find_first_not_of(" \t\n", equals + 1) == std::string::npos) {
        const int source = problems.add_source({"--set", "", text, true});
        problems.add({source, 1, 1, characters(text)}, "an override needs a key and a value",
                     "write for example --set solver.spacing=0.01");
        return;
    }
    // The value is parsed in its place within the whole text, the key blanked out, so that problems point into what was
    // typed.
    const int source = problems.add_source({"--set", "", std::string(equals + 1, ' ') + text.substr(equals + 1), true});
    std::optional<Value> value = read_yaml(source, problems);
    problems.replace_text(source, text);
    if (!value) return;
    Value* place = &tree;
    std::vector<std::string> labels;
    for (const Step& step : split_path(text.substr(0, equals))) {
        make_room(*place, step.label, labels);
        place = descend(*place, step, source, problems);
        if (!place) return;
        labels.push_back(step.label);
    }
    if (value->type == Value::Type::null) *place = *value;  // ~: the reader says that a value is missing
    overlay(*place, *value, labels);
}

}  // namespace thixo::scene
