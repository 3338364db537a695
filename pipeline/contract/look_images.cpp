#include "pipeline/contract/look_images.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/scene_check.h"

namespace thixo::scene {
namespace {

constexpr std::string_view kPng = "\x89PNG", kExr = "\x76\x2f\x31\x01", kJpeg = "\xff\xd8\xff", kHdr = "#?";

std::string read_image(const std::string& file) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
        throw InputError("there is no image file {}", shown(file, kPathShown));
    try {
        return read_whole(file);
    } catch (const CacheError& e) {
        throw InputError("{}", e.what());
    }
}

void require_values(const Image& image, const std::string& file, ImageUse use) {
    const float most = use == ImageUse::texture ? 1.0f : std::numeric_limits<float>::max();
    for (const char* name : {"R", "G", "B"}) {
        const ImageChannel* channel = image.find(name);
        if (!channel) throw InputError("the image '{}' has no channel {}; export it as RGB", file, name);
        for (std::size_t k = 0; k < channel->values.size(); ++k) {
            const float v = channel->values[k];
            if (v >= 0 && v <= most) continue;
            const std::size_t width = std::size_t(image.width);
            throw InputError("the image '{}' has {} = {} at column {} of row {}; {}", file, name, v, k % width,
                             k / width,
                             use == ImageUse::texture ? "colours go from 0 to 1" : "light is finite and not negative");
        }
    }
}

}  // namespace

std::string_view image_extension(std::string_view bytes) {
    if (bytes.starts_with(kPng)) return ".png";
    if (bytes.starts_with(kExr)) return ".exr";
    if (bytes.starts_with(kJpeg)) return ".jpg";
    if (bytes.starts_with(kHdr)) return ".hdr";
    return {};
}

bool has_8_bits(std::string_view extension) { return extension == ".png" || extension == ".jpg"; }

Image decode_linear(std::string_view bytes, const std::string& file) {
    return image_extension(bytes) == ".hdr" ? decode_hdr(bytes, file) : decode_exr(bytes, file);
}

Image8 decode_8_bits(std::string_view bytes, const std::string& file) {
    return image_extension(bytes) == ".jpg" ? decode_jpeg(bytes, file) : decode_png(bytes, file);
}

void require_usable_image(std::string_view bytes, const std::string& file, ImageUse use) {
    const std::string_view type = image_extension(bytes);
    const bool environment = use == ImageUse::environment;
    if (type.empty() || (environment && has_8_bits(type)))
        throw InputError("'{}' is not {}", file, environment ? "an EXR or HDR" : "a PNG, JPEG, EXR or HDR");
    try {
        if (has_8_bits(type)) {
            decode_8_bits(bytes, file);
            return;
        }
        const Image image = decode_linear(bytes, file);
        if (environment && image.width != 2 * image.height)
            throw InputError("the environment '{}' has {} x {} pixels; it must be twice as wide as high", file,
                             image.width, image.height);
        require_values(image, file, use);
    } catch (const CacheError& e) {  // an image a user names is input
        throw InputError("{}", e.what());
    }
}

void read_image_hashes(Look& look, ReadContext& context) {
    struct Read {
        std::string hash, problem;
    };
    std::map<std::pair<std::string, ImageUse>, Read> read;  // each file once
    for_each_image(look, [&](const std::string& path, ImageUse use, std::string& file, std::string& content) {
        const auto at = [&](const char* key) {
            const auto found = context.where.find(path + key);
            return found == context.where.end() ? Position{} : found->second;
        };
        const int from = at(".file").source, content_from = at(".content").source;
        const auto set = [&](int source) { return source >= 0 && context.problems.source(source).is_override; };
        if (context.closed.contains(file)) return;
        if (from < 0 || (context.files == Files::ignore && !set(from))) return;  // read already, and maybe gone
        if (content_from != from && !set(content_from)) content.clear();         // it was another file's
        const auto [entry, added] = read.try_emplace({file, use});
        if (added) {
            try {
                const std::string bytes = read_image(file);
                entry->second.hash = hash_hex(bytes);
                require_usable_image(bytes, file, use);
            } catch (const InputError& e) {
                entry->second.problem = e.what();
            }
        }
        const auto& [hash, problem] = entry->second;
        if (!problem.empty())
            context.problems.add(at(".file"), problem);
        else if (!content.empty() && content != hash)
            context.problems.add(at(".content"), fmt::format("the image file {} has changed: its content is {}",
                                                             shown(file, kPathShown), hash));
        else
            content = hash;
    });
}

std::string image_bytes(const std::string& file, const std::string& content, const CacheReader* cache) {
    if (cache && cache->has_asset(content)) return cache->load_asset(content);
    if (file == content)  // of a cache's scene: it can be nowhere else
        throw CacheError("'{}' lacks the image {} that its look names; simulate again with --restart",
                         cache ? cache->folder().string() : "the cache", content);
    std::string bytes = read_image(file);
    if (hash_hex(bytes) != content)
        throw InputError("the image file {} is no longer the one the look was read with; start again",
                         shown(file, kPathShown));
    return bytes;
}

double pixels_of(std::string_view image, const std::string& file) {
    const std::string_view type = image_extension(image);
    if (type == ".png") return png_pixels(image, file);
    if (type == ".jpg") return jpeg_pixels(image, file);
    return type == ".hdr" ? hdr_pixels(image, file) : exr_pixels(image, file);
}

void store_images(const Look& look, CacheWriter& cache) {
    for_each_image(look, [&](const std::string&, ImageUse, const std::string& file, const std::string& content) {
        const std::string bytes = image_bytes(file, content, nullptr);
        cache.add_asset(bytes, image_extension(bytes));
    });
}

}  // namespace thixo::scene
