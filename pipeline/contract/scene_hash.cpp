#include "pipeline/contract/scene_hash.h"

#include <fmt/format.h>

#include <map>

#include "pipeline/contract/hash.h"
#include "pipeline/contract/scene_build.h"

namespace thixo::scene {
namespace {

using Line = std::pair<std::string, std::string>;  // key path, value

void flatten(const Value& value, const std::string& path, std::vector<Line>& lines) {
    if (value.items.empty() || value.type == Value::Type::scalar) {
        lines.emplace_back(path, print_value(value));
        return;
    }
    for (std::size_t k = 0; k < value.items.size(); ++k) {
        const std::string label = value.type == Value::Type::map ? value.labels[k].text : std::to_string(k);
        flatten(value.items[k], path.empty() ? label : path + "." + label, lines);
    }
}

bool simulation_depends(const std::string& path) {
    // Where a file lies is of no matter: its content is a key of its own.
    return path != "frames.last" && path != "solver.checkpoint_every" && !path.ends_with(".mesh.file") &&
           !path.ends_with(".image.file");
}

std::vector<Line> simulation_lines(const Scene& scene) {
    Value tree = to_block(scene);
    tree.remove("scene");
    tree.remove("look");
    std::vector<Line> all, lines;
    flatten(tree, "", all);
    for (Line& line : all)
        if (simulation_depends(line.first)) lines.push_back(std::move(line));
    return lines;
}

std::string hash_lines(const std::vector<Line>& lines) {
    std::string text;
    for (const auto& [path, value] : lines) text += path + ": " + value;
    return hash_hex(text);
}

// The named list that a key path belongs to, for entries that stand in another order.
std::string block_of(const std::string& path) {
    const std::size_t dots = path.starts_with("world.") ? path.find('.', 6) : path.find('.');
    return path.substr(0, dots);
}

}  // namespace

std::string simulation_hash(const Scene& scene) { return hash_lines(simulation_lines(scene)); }

std::vector<Line> look_lines(const Look& look) {
    Look pictures = look;
    pictures.output.film = Output{}.film;
    std::vector<Line> all, lines;
    flatten(to_block(pictures), "look", all);
    for (Line& line : all)  // where an image lies is of no matter: its content is a key of its own
        if (!line.first.ends_with(".file")) lines.push_back(std::move(line));
    return lines;
}

std::string look_hash(const Look& look) { return hash_lines(look_lines(look)); }

std::vector<std::string> differing_keys(const Scene& a, const Scene& b) {
    const std::vector<Line> lines_a = simulation_lines(a), lines_b = simulation_lines(b);
    const std::map<std::string, std::string> map_a(lines_a.begin(), lines_a.end()),
        map_b(lines_b.begin(), lines_b.end());
    std::vector<std::string> keys;
    for (const auto& [path, value] : lines_a) {
        const auto other = map_b.find(path);
        if (other == map_b.end() || other->second != value) keys.push_back(path);
    }
    for (const auto& [path, value] : lines_b)
        if (!map_a.count(path)) keys.push_back(path);
    if (!keys.empty()) return keys;
    for (std::size_t k = 0; k < lines_a.size(); ++k)
        if (lines_a[k].first != lines_b[k].first) return {block_of(lines_a[k].first) + " (the order of its entries)"};
    return {};
}

}  // namespace thixo::scene
