#include "pipeline/contract/scene_checker.h"

#include <fmt/format.h>

#include <algorithm>

namespace thixo::scene {

Position position_of(const ReadContext& context, std::string path) {
    while (true) {
        if (const auto found = context.where.find(path); found != context.where.end()) return found->second;
        const std::size_t dot = path.rfind('.');
        if (dot == std::string::npos) return {};
        path.resize(dot);
    }
}

void Checker::refer(const std::string& name, const std::vector<std::string>& names, const std::string& path,
                    const char* what) const {
    if (name.empty()) return;  // left out, or already a problem
    if (std::find(names.begin(), names.end(), name) != names.end()) return;
    require(false, path, fmt::format("there is no {} \"{}\"", what, name),
            names.empty() ? fmt::format("the scene has no {}s", what) : suggestion(name, names));
}

void check_motion(const std::vector<Key>& motion, const std::string& path, const Checker& check) {
    for (std::size_t k = 1; k < motion.size(); ++k)
        check.require(motion[k].time > motion[k - 1].time, fmt::format("{}.{}.time", path, k),
                      fmt::format("\"time\" must ascend: {} is not after {}", motion[k].time, motion[k - 1].time));
    for (std::size_t k = 1; k < motion.size(); ++k)
        check.require((motion[k].rotate - motion[k - 1].rotate).cwiseAbs().maxCoeff() < 180,
                      fmt::format("{}.{}.rotate", path, k),
                      "\"rotate\" changes by 180 degrees or more from the key before: the way round would be lost",
                      "add a key between them");
}

}  // namespace thixo::scene
