// The image files of a look: environments and textures.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/contract/cache.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/scene.h"

namespace thixo::scene {

enum class ImageUse { environment, texture };

/// f(key path, use, file, content) for every image file the look names; L is Look or const Look.
template <class L, class F>
void for_each_image(L& look, F&& f) {
    for (auto& l : look.lights)
        if (l.type == LightType::environment) f("look.lights." + l.name, ImageUse::environment, l.file, l.content);
    for (auto& a : look.appearances)
        if (!a.image.file.empty())
            f("look.appearances." + a.name + ".image", ImageUse::texture, a.image.file, a.image.content);
}

/// ".png", ".jpg", ".exr" or ".hdr", told from the first bytes and not from the name; empty where it is none of them.
std::string_view image_extension(std::string_view bytes);

/// The picture of an image of linear light. Throws CacheError as decode_exr and decode_hdr do.
Image decode_linear(std::string_view bytes, const std::string& file);
/// The picture of an image of 8 bits. Throws CacheError as decode_png and decode_jpeg do.
Image8 decode_8_bits(std::string_view bytes, const std::string& file);
/// Whether an image of this type has 8 bits a channel, sRGB.
bool has_8_bits(std::string_view extension);

/// Throws InputError where the bytes are no image for this use:
///
/// - any image of another type, damaged, or without colour
/// - an environment that is not twice as wide as high, or has values that are negative or not finite
/// - a texture with values outside of [0, 1]
void require_usable_image(std::string_view bytes, const std::string& file, ImageUse use);

/// The bytes of an image: from the cache where it has them, else from the file, which must have this content. An image
/// of a cache's scene (print_cached_scene) is in the cache or nowhere. Throws InputError where the file has changed,
/// CacheError where the cache is damaged or lacks the image.
std::string image_bytes(const std::string& file, const std::string& content, const CacheReader* cache);

/// Pixels of an image as its header states them, without decoding any. Throws CacheError.
double pixels_of(std::string_view image, const std::string& file);

/// Stores the look's images in the cache, so that it can be rendered without them. Throws as image_bytes.
void store_images(const Look& look, CacheWriter& cache);

}  // namespace thixo::scene
