// Which appearance a body or an obstacle of a frame wears.
#pragma once

#include <string>

#include "pipeline/contract/frame.h"
#include "pipeline/contract/scene.h"

namespace thixo {

/// The name of the body's own look in the scene, else its material's; what the scene does not know wears its own name.
std::string look_of_body(const scene::Scene& scene, const FrameBody& body);
std::string look_of_obstacle(const scene::Scene& scene, const FrameObstacle& obstacle);

}  // namespace thixo
