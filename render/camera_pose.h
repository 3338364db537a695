// Where a look's camera is at one instant: the same for pictures and previews.
#pragma once

#include "pipeline/contract/scene.h"

namespace thixo::render {

struct CameraPose {
    Vec3d position{0, 0, 0};  // [m]
    Vec3d to{0, 1, 0};        // from there to the point in the middle of the picture [m]
    Vec3d up{0, 0, 1};        // any length
    double fov = 40;          // horizontal [degrees]
};

/// At `time` [s]. The camera is on its path, or at its place. It goes round look_at by its orbit. Then its motion turns
/// it about itself and shifts it. Throws InputError where position and look_at are the same, or up is along the view.
CameraPose camera_pose(const scene::Camera& camera, double time);

}  // namespace thixo::render
