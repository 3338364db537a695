// Notes what is wrong with a scene at the place of a key. For the checks of scene_check*.cpp alone.
#pragma once

#include <string>
#include <vector>

#include "pipeline/contract/scene_reader.h"

namespace thixo::scene {

/// Where a key stands, or the nearest block around it that is written.
Position position_of(const ReadContext& context, std::string path);

struct Checker {
    ReadContext& context;

    void require(bool good, const std::string& path, std::string message, std::string hint = {}) const {
        if (!good) context.problems.add(position_of(context, path), std::move(message), std::move(hint));
    }
    /// A name that is left out is no problem here.
    void refer(const std::string& name, const std::vector<std::string>& names, const std::string& path,
               const char* what) const;
};

template <class T>
std::vector<std::string> names_of(const std::vector<T>& entries) {
    std::vector<std::string> names;
    for (const T& entry : entries) names.push_back(entry.name);
    return names;
}

void check_motion(const std::vector<Key>& motion, const std::string& path, const Checker& check);

/// What maps an image by uv is worn by meshes alone. (Whether a mesh's file has texture coordinates, its reader tells.)
/// What glows by its temperature is worn by matter alone.
void check_wearers(const Scene& scene, const Checker& check);

}  // namespace thixo::scene
