// Entries of a scene's lists, by name.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace thixo::scene {

template <class T>
const T& entry(const std::vector<T>& list, const std::string& name) {
    for (const T& t : list)
        if (t.name == name) return t;
    throw std::runtime_error("no " + name);
}

}  // namespace thixo::scene
