// The images a look names, made ready.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "pipeline/contract/cache.h"
#include "pipeline/contract/scene.h"
#include "render/environment.h"
#include "render/texture.h"

namespace thixo::render {

/// By content hash.
struct Pictures {
    std::map<std::string, std::shared_ptr<const Environment>> environments;
    std::map<std::string, std::shared_ptr<const Texture>> textures;
};

/// Reads every image of the look, from the cache where it has it, else from its file. Throws InputError for an image
/// that is missing or cannot be used, CacheError where the cache is damaged.
Pictures load_pictures(const scene::Look& look, const CacheReader* cache);

/// From the bytes of a file; `name` stands for it in messages. Throw InputError.
std::shared_ptr<const Environment> make_environment(std::string_view bytes, const std::string& name);
std::shared_ptr<const Texture> make_texture(std::string_view bytes, const std::string& name);

}  // namespace thixo::render
