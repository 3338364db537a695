// Rigid motion along keys as scenes give them.
#pragma once

#include <vector>

#include "pipeline/geometry/keyframes.h"

namespace thixo {

/// Smooth between keys that have `time` [s], `position` [m] and `rotate` [degrees about x, then y, then z]. Without keys
/// it is the identity. Throws as motion_from_degrees does.
template <class Key>
RigidMotion motion_along(const std::vector<Key>& keys) {
    if (keys.empty()) return {};
    std::vector<double> times;
    std::vector<Vec3d> positions, degrees;
    for (const Key& k : keys) {
        times.push_back(k.time);
        positions.push_back(k.position);
        degrees.push_back(k.rotate);
    }
    return motion_from_degrees(times, positions, degrees);
}

}  // namespace thixo
