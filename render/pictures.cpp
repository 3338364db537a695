#include "render/pictures.h"

#include <array>

#include "pipeline/contract/image.h"
#include "pipeline/contract/look_images.h"
#include "pipeline/geometry/colour_code.h"

namespace thixo::render {
namespace {

using scene::ImageUse;

std::vector<Vec3f> colours_of(const Image& image) {
    const std::vector<float>&r = image.get("R"), &g = image.get("G"), &b = image.get("B");
    std::vector<Vec3f> colours(image.pixels());
    for (std::size_t k = 0; k < colours.size(); ++k) colours[k] = {r[k], g[k], b[k]};
    return colours;
}

std::vector<Vec3f> colours_of(const Image8& image) {
    std::array<float, 256> linear;
    for (std::size_t k = 0; k < linear.size(); ++k) linear[k] = linear_from_srgb(float(k) / 255);
    const auto step = std::size_t(image.channels);
    std::vector<Vec3f> colours(image.values.size() / step);
    for (std::size_t k = 0; k < colours.size(); ++k) {
        const std::uint8_t* const p = image.values.data() + k * step;
        colours[k] = {linear[p[0]], linear[p[1]], linear[p[2]]};
    }
    return colours;
}

}  // namespace

std::shared_ptr<const Environment> make_environment(std::string_view bytes, const std::string& name) {
    scene::require_usable_image(bytes, name, ImageUse::environment);
    const Image image = scene::decode_linear(bytes, name);
    return std::make_shared<const Environment>(image.width, image.height, colours_of(image));
}

std::shared_ptr<const Texture> make_texture(std::string_view bytes, const std::string& name) {
    scene::require_usable_image(bytes, name, ImageUse::texture);
    if (scene::has_8_bits(scene::image_extension(bytes))) {
        const Image8 image = scene::decode_8_bits(bytes, name);
        return std::make_shared<const Texture>(image.width, image.height, colours_of(image));
    }
    const Image image = scene::decode_linear(bytes, name);
    return std::make_shared<const Texture>(image.width, image.height, colours_of(image));
}

Pictures load_pictures(const scene::Look& look, const CacheReader* cache) {
    Pictures pictures;
    scene::for_each_image(look,
                          [&](const std::string&, ImageUse use, const std::string& file, const std::string& content) {
                              const std::string bytes = scene::image_bytes(file, content, cache);
                              if (use == ImageUse::environment)
                                  pictures.environments[content] = make_environment(bytes, file);
                              else
                                  pictures.textures[content] = make_texture(bytes, file);
                          });
    return pictures;
}

}  // namespace thixo::render
