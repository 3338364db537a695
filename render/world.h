// Everything one picture is made of.
#pragma once

#include <memory>
#include <vector>

#include "render/camera.h"
#include "render/lights.h"
#include "render/material.h"
#include "render/ray_scene.h"

namespace thixo::render {

/// How light is followed (scene::Output).
struct PathSettings {
    int max_bounces = 12;  // hits of a path, but for total reflections
    bool straight_shadows = true;
    float clamp = 20;  // W/(m^2 sr), of indirect radiance of one sample; 0: none
    bool transparent_background = false;
};

/// Immutable while a picture is made. An object is what a ray can be inside of: a body or an obstacle.
struct World {
    std::unique_ptr<RayScene> rays;
    std::vector<Index> material_of;  // by object
    std::vector<Material> materials;
    std::vector<Light> lights;
    Vec3f background{0, 0, 0};  // radiance seen where there is no sky
    PathSettings settings;
    Camera camera;
    bool attributes = false;   // some material looks at the attributes of hits
    Interior camera_interior;  // the objects the camera is inside of

    const Material& material(Index object) const { return materials[material_of[object]]; }
    /// Of an object that a ray can be inside of.
    const Dielectric& medium(Index object) const { return std::get<Dielectric>(material(object).surface); }
};

}  // namespace thixo::render
