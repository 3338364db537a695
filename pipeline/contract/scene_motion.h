// Rigid motions in the scene file.
#pragma once

#include "pipeline/base/math.h"
#include "pipeline/contract/scene_key.h"

namespace thixo::scene {

struct Key {                  // one instant of a rigid motion
    double time = 0;          // s
    Vec3d position{0, 0, 0};  // m
    Vec3d rotate{0, 0, 0};    // degrees about x, then y, then z
};
template <class V>
void visit(V& v, Key& k) {
    v.key("time", k.time, "s", required(), "instant; ascending in the list");
    v.key("position", k.position, "m", any(), "shift from the place given in the scene, after the turn");
    v.key("rotate", k.rotate, "degrees", any(),
          "turn about the world's x, then y, then z axis (a camera: about axes through itself)");
}

}  // namespace thixo::scene
