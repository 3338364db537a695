// Shapes of the scene as signed distance functions.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/contract/scene.h"
#include "pipeline/geometry/keyframes.h"
#include "pipeline/geometry/shape.h"

namespace thixo {

/// Builds the distance function of a scene's shape: its kind, then scale, rotate, translate, offset and shell. Names
/// are looked up in scene.shapes. Throws InputError, led by the shape's file:line:column, where a size or a mesh is bad
/// or a name leads back to itself.
Shape make_shape(const scene::Scene& scene, const scene::Shape& shape);

/// Calls make(). Where that throws InputError, the message then begins with the shape's place in the scene and what it is
/// of: "file:line:column: body 'NAME': ...".
template <class F>
auto named_in_scene(const scene::Shape& shape, std::string_view what, std::string_view name, F&& make) {
    try {
        return make();
    } catch (const InputError& error) {
        const std::string_view said = error.what();
        if (said.starts_with(shape.where)) throw;
        throw InputError("{}: {} '{}': {}", shape.where, what, name, said);
    }
}

/// One warning for every mesh file of the scene that is open, inside out, or wound both ways, however many shapes are
/// made of it.
void warn_of_meshes(const scene::Scene& scene);

/// The solid of a boundary in its own frame: its shape, or what lies outside of it where the boundary is a room.
Shape wall_solid(const scene::Scene& scene, const scene::Boundary& boundary);
/// The same where a boundary that does not move stands in the world.
Shape wall_solid_at_rest(const scene::Scene& scene, const scene::Boundary& boundary);

/// Keyframes, smooth between keys. They turn about the world's origin, wherever the scene's places count from.
RigidMotion motion_of(const scene::Scene& scene, const std::vector<scene::Key>& keys);

/// The scene, its places relative to an origin that single precision holds them from (scene_origin.h). Meshes that stand
/// where their files say are read. Of a scene near its origin, or of what this gave: the same. Throws InputError.
scene::Scene near_origin(const scene::Scene& scene);

/// "(x, y, z)" of a place of the scene [m], in the world, for messages.
std::string place_text(const scene::Scene& scene, const Vec3& x);

}  // namespace thixo
