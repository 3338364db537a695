// How a picture is laid on a surface.
#pragma once

#include <memory>

#include "pipeline/contract/scene.h"
#include "render/ray.h"
#include "render/texture.h"

namespace thixo::render {

/// scene::ImageTexture made ready.
struct ImageMap {
    std::shared_ptr<const Texture> texture;  // none: there is no picture
    scene::Mapping mapping = scene::Mapping::planar;
    int axis = 2;
    Vec3f origin{0, 0, 0};  // m
    Vec2f size{1, 1};       // m, or of uv

    bool by_uv() const { return texture && mapping == scene::Mapping::uv; }
    /// The picture's colour there, filtered over the hit's footprint. in_rest: laid on m0, else on the world.
    Vec3f colour(const Hit& hit, bool in_rest) const;
};

}  // namespace thixo::render
