// Small worlds for tests of light.
#pragma once

#include "render/film.h"
#include "render/media.h"
#include "tests/render/surfel_shapes.h"

namespace thixo::render::worlds {

inline Index add_object(World& world, const scene::Appearance& a) {
    world.materials.push_back(make_material(a));
    world.material_of.push_back(Index(world.materials.size() - 1));
    world.inside_of.push_back(world.material_of.back());
    return Index(world.material_of.size() - 1);
}

/// A square about the origin in the plane z = 0, seen from above.
inline MeshObject ground(Index object, float half = 50) {
    MeshObject g;
    g.mesh.vertices = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
    g.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    g.object = object;
    return g;
}

inline void add_sky(World& world, double strength = 1) {
    scene::Light sky;
    sky.strength = strength;
    sky.ground = {1, 1, 1};
    world.lights.push_back(make_light(sky));
}

inline void look(World& world, const Vec3d& from, const Vec3d& at, double fov, int width, int height) {
    scene::Camera camera;
    camera.position = from;
    camera.look_at = at;
    camera.up = {0, 1, 0.1};
    camera.fov = fov;
    world.camera = camera_at(camera, 0, width, height);
}

/// Mean of R, G, B over the picture.
inline Vec3d mean_colour(const Image& image) {
    Vec3d sum = Vec3d::Zero();
    int k = 0;
    for (const char* c : {"R", "G", "B"}) {
        for (const float v : image.get(c)) sum[k] += double(v);
        ++k;
    }
    return sum / double(image.pixels());
}

/// The standard error of mean_colour's green.
inline double standard_error(const Image& image) {
    double sum = 0;
    for (const float v : image.get("variance.G")) sum += double(v);
    return std::sqrt(sum) / double(image.pixels());
}

}  // namespace thixo::render::worlds
