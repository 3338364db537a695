#include "pipeline/contract/frame_looks.h"

namespace thixo {
namespace {

std::string look_of_material(const scene::Scene& scene, const std::string& material) {
    for (const scene::Material& m : scene.materials)
        if (m.name == material) return m.look.empty() ? m.name : m.look;
    return material;
}

}  // namespace

std::string look_of_body(const scene::Scene& scene, const FrameBody& body) {
    for (const scene::Body& b : scene.bodies)
        if (b.name == body.name && !b.look.empty()) return b.look;
    return look_of_material(scene, body.material);
}

std::string look_of_obstacle(const scene::Scene& scene, const FrameObstacle& obstacle) {
    for (const scene::Boundary& b : scene.world.boundaries)
        if (b.name == obstacle.name) return b.look.empty() ? b.name : b.look;
    return obstacle.look.empty() ? obstacle.name : obstacle.look;
}

}  // namespace thixo
