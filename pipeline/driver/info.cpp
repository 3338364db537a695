#include "pipeline/contract/info.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/printable.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/driver/command.h"
#include "pipeline/driver/json_output.h"

namespace thixo {
namespace {

template <class List>
nlohmann::ordered_json names(const List& list) {
    nlohmann::ordered_json found = nlohmann::ordered_json::array();
    for (const auto& item : list) found.push_back(item.name);
    return found;
}

nlohmann::ordered_json describe_scene(const scene::Scene& scene) {
    return {{"scene", scene.name},
            {"title", scene.title},
            {"frames", {{"first", scene.frames.first}, {"last", scene.frames.last}, {"fps", scene.frames.fps}}},
            {"spacing", scene.solver.spacing},
            {"boundaries", names(scene.world.boundaries)},
            {"materials", names(scene.materials)},
            {"bodies", names(scene.bodies)},
            {"emitters", names(scene.emitters)},
            {"lights", names(scene.look.lights)},
            {"appearances", names(scene.look.appearances)},
            {"width", scene.look.output.width},
            {"height", scene.look.output.height},
            {"samples", scene.look.output.samples}};
}

/// A line a key, lists and blocks on one line.
std::string text_of(const nlohmann::ordered_json& facts) {
    std::string text;
    for (const auto& [key, value] : facts.items())
        text += fmt::format("{:<12} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
    return text;
}

}  // namespace

int info_verb(const Command& command) {
    if (!std::filesystem::exists(command.path)) throw InputError("{}: there is no such file or folder", command.path);
    if (describes(command.path)) {
        std::fputs(printable(describe(command.path, command.json)).c_str(), stdout);
        return kDone;
    }
    if (std::filesystem::is_directory(command.path))
        throw CacheError("{}: holds no cache; ./thixo sim SCENE makes one", command.path);
    const nlohmann::ordered_json facts = describe_scene(scene::load_scene(command.path));
    if (command.json)
        print_json(facts);
    else
        std::fputs(printable(text_of(facts)).c_str(), stdout);
    return kDone;
}

}  // namespace thixo
