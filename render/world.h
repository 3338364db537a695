// Everything one picture is made of.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/lights.h"
#include "render/material.h"
#include "render/ray_scene.h"
#include "render/shutter.h"

namespace thixo::render {

/// How light is followed (scene::Output).
struct PathSettings {
    int max_bounces = 12;  // hits of a path, but for total reflections
    bool straight_shadows = true;
    float clamp = 20;  // W/(m^2 sr), of indirect radiance of one sample; 0: none
    bool transparent_background = false;
};

/// What passes say of an object.
struct ObjectLabel {
    std::string name;        // of the body or boundary; parts of a body that split have ".<id>" behind it
    std::string appearance;  // what it looks like
    int body = -1;           // id in the frame; -1: no body
    std::uint32_t object_id = 0, material_id = 0;                         // of Cryptomatte, by name and appearance
    Vec3f origin{0, 0, 0}, velocity{0, 0, 0}, angular_velocity{0, 0, 0};  // of a mesh [m], [m/s], [rad/s]
};

/// The camera a frame before and a frame after.
struct Neighbours {
    Camera before, after;
    float seconds = 0;  // between two frames
};

/// Immutable while a picture is made. An object is what a ray can be inside of: a body or an obstacle.
struct World {
    std::unique_ptr<RayScene> rays;
    std::vector<Index> material_of;  // by object
    std::vector<Index> inside_of;    // by object: the material that cracks lay open
    std::vector<Material> materials;
    std::vector<Light> lights;
    LightGroups light_groups;
    Vec3f background{0, 0, 0};  // radiance seen where there is no sky
    PathSettings settings;
    Vec3d origin{0, 0, 0};  // what all places of this world count from [m]
    Camera camera;
    Shutter shutter;
    std::array<Camera, 2> moving_camera;  // as the shutter opens and closes, where it moves
    bool attributes = false;              // some material looks at the attributes of hits
    Interior camera_interior;             // the objects the camera is inside of
    scene::Passes passes;                 // those beside the ones that are always there
    std::vector<ObjectLabel> labels;      // by object, where one of these passes needs them
    Neighbours neighbours;                // where motion is asked for

    /// The camera at a ray's time.
    Camera camera_then(float time) const {
        return shutter.moves() ? between(moving_camera[0], moving_camera[1], time) : camera;
    }
    Ray camera_ray(float x, float y, const Vec2f& lens, float time) const {
        Ray ray = camera_then(time).ray(x, y, lens);
        ray.time = time;
        return ray;
    }
    const Material& material(Index object) const { return materials[material_of[object]]; }
    /// Of the surface that was hit.
    const Material& material(const Hit& hit) const {
        return materials[(hit.sheet < kFirstCrackSheet ? material_of : inside_of)[hit.object]];
    }
    /// Of an object that a ray can be inside of.
    const Dielectric& medium(Index object) const { return std::get<Dielectric>(material(object).surface); }
};

}  // namespace thixo::render
