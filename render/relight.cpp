#include "render/relight.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/contract/scene_hash.h"

namespace thixo::render {
namespace {

using nlohmann::json;

/// PNG and film alone depend on these, or nothing that relighting could not do. Numbers of a list have ".0" and so on
/// behind the key.
bool is_free(const std::string& line) {
    constexpr std::array<std::string_view, 5> kFree{"look.background", "look.output.exposure", "look.output.view",
                                                    "look.output.film", "look.output.passes.lights"};
    const bool of_list = std::isdigit(static_cast<unsigned char>(line.back())) != 0;
    const std::string key = of_list ? line.substr(0, line.rfind('.')) : line;
    return std::ranges::find(kFree, key) != kFree.end() ||
           (key.starts_with("look.lights.") && (key.ends_with(".strength") || key.ends_with(".colour"))) ||
           (key.starts_with("look.appearances.") && (key.ends_with(".glow.strength") || key.ends_with(".glow.colour")));
}

json numbers(const Vec3d& v) { return {v.x(), v.y(), v.z()}; }
Vec3d vector(const json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()}; }

/// now / before, by colour. Nothing where no factor leads from one to the other; 1 where both are black.
std::optional<Vec3d> factor_between(const Vec3d& before, const Vec3d& now) {
    Vec3d factor(1, 1, 1);
    for (int c = 0; c < 3; ++c) {
        if (before[c] == 0 && now[c] != 0) return std::nullopt;
        if (before[c] != 0) factor[c] = now[c] / before[c];
    }
    return factor;
}

/// A light that was black says nothing of its group.
bool agree(const Vec3d& a, const Vec3d& b, const Vec3d& light) {
    for (int c = 0; c < 3; ++c)
        if (light[c] != 0 && std::abs(a[c] - b[c]) > 1e-9 * std::max(std::abs(a[c]), std::abs(b[c]))) return false;
    return true;
}

/// The first key whose values differ; empty: none does.
std::string differing_key(const json& a, const json& b) {
    for (const auto& [key, value] : a.items())
        if (!b.contains(key) || b.at(key) != value) return key;
    for (const auto& [key, value] : b.items())
        if (!a.contains(key)) return key;
    return {};
}

/// Of a light by its name in a record; black where it has none of that name.
Vec3d light_of(const json& group, const std::string& name) {
    return group.contains(name) ? vector(group.at(name)) : Vec3d(0, 0, 0);
}

/// Has the keys of both.
json both(json before, const json& now) {
    before.update(now);
    return before;
}

/// Adds what a group's lights change by. Returns the reason where that is no single factor.
std::string mix_group(const std::string& group, const json& before, const json& now, Relighting& result) {
    Vec3d factor(1, 1, 1), known(0, 0, 0);  // known: not zero where a light has told the factor
    const json names = both(before, now);
    for (const auto& [name, ignored] : names.items()) {
        const Vec3d was = light_of(before, name);
        const std::optional<Vec3d> f = factor_between(was, light_of(now, name));
        if (!f) return fmt::format("{}{} gave no light before", name.starts_with("look.") ? "" : "look.lights.", name);
        if (!agree(*f, factor, was.cwiseProduct(known)))
            return fmt::format("the lights of the group '{}' change by different factors", group);
        for (int c = 0; c < 3; ++c)
            if (was[c] != 0) {
                factor[c] = (*f)[c];
                known[c] = 1;
            }
    }
    result.factor[group] = factor;
    return {};
}

}  // namespace

std::string light_record(const scene::Scene& scene, std::uint64_t seed) {
    json record;
    record["groups"][scene::kBackgroundGroup] = {{"look.background", numbers(scene.look.background)}};
    for (const scene::Light& l : scene.look.lights)
        record["groups"][scene::group_of(l)][l.name] = numbers(l.colour * l.strength);
    for (const scene::Appearance& a : scene.look.appearances)
        if (scene::glows(a))
            record["groups"][scene::kGlowGroup]["look.appearances." + a.name + ".glow"] =
                numbers(a.glow.colour * a.glow.strength);
    json& keys = record["keys"];
    keys["seed"] = seed;
    for (const auto& [key, value] : scene::look_lines(scene.look))
        if (!is_free(key)) keys[key] = value;
    for (const scene::Material& m : scene.materials) keys["materials." + m.name + ".look"] = m.look;
    for (const scene::Body& b : scene.bodies) keys["bodies." + b.name + ".look"] = b.look;
    for (const scene::Boundary& b : scene.world.boundaries) keys["world.boundaries." + b.name + ".look"] = b.look;
    return record.dump();
}

Relighting relighting(const std::string& stored, const std::string& wanted) {
    Relighting result;
    const json before = json::parse(stored), now = json::parse(wanted);
    if (const std::string key = differing_key(before.at("keys"), now.at("keys")); !key.empty())
        result.reason = key + " differs";
    const json &groups_before = before.at("groups"), &groups_now = now.at("groups");
    const json groups = both(groups_before, groups_now);
    for (const auto& [group, ignored] : groups.items()) {
        const json none = json::object();
        const bool was = groups_before.contains(group), is = groups_now.contains(group);
        if (!was && result.reason.empty()) result.reason = fmt::format("its picture has no light group '{}'", group);
        if (!is) result.gone.insert(group);
        if (result.reason.empty())
            result.reason =
                mix_group(group, was ? groups_before.at(group) : none, is ? groups_now.at(group) : none, result);
    }
    return result;
}

bool Relighting::is_same() const {
    return gone.empty() &&
           std::ranges::all_of(factor, [](const auto& group) { return group.second == Vec3d(1, 1, 1); });
}

bool has_light_groups(const Image& image) {
    return std::ranges::any_of(image.channels, [](const ImageChannel& c) { return c.name.starts_with("light_"); });
}

Image relit(Image image, const Relighting& mix) {
    const std::array<std::string, 3> colours{"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        const std::string& colour = colours[std::size_t(c)];
        std::vector<double> sum(image.pixels(), 0.0);
        for (const auto& [group, f] : mix.factor) {
            ImageChannel* const channel = image.find(fmt::format("light_{}.{}", group, colour));
            if (!channel) throw CacheError("the picture has no light group '{}'; render it again", group);
            for (std::size_t i = 0; i < sum.size(); ++i) {
                channel->values[i] = float(f[c] * double(channel->values[i]));
                sum[i] += double(channel->values[i]);
            }
        }
        std::ranges::transform(sum, image.find(colour)->values.begin(),
                               [](double s) { return float(std::max(0.0, s)); });
    }
    std::erase_if(image.channels, [&](const ImageChannel& c) {
        const std::string layer = c.name.substr(0, c.name.find('.'));
        return layer == "noisy" || layer == "variance" ||
               (layer.starts_with("light_") && mix.gone.contains(layer.substr(6)));
    });
    return image;
}

}  // namespace thixo::render
