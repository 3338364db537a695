#include "pipeline/contract/image.h"

#include <png.h>

#include <algorithm>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"

namespace thixo {
namespace {

constexpr png_uint_32 kLargestSide = 1 << 14;  // 4 bytes a pixel still fit 32 bits, in which libpng counts
constexpr std::size_t kLargestRatio = 1100;    // of deflate

png_image start(png_uint_32 width, png_uint_32 height, png_uint_32 format) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = width;
    png.height = height;
    png.format = format;
    return png;
}

}  // namespace

std::vector<float>& Image::add(std::string name, bool half) {
    THIXO_ASSERT(!find(name), "channel {} is there twice", name);
    channels.push_back({std::move(name), half, std::vector<float>(pixels())});
    return channels.back().values;
}

const ImageChannel* Image::find(std::string_view name) const {
    const auto it =
        std::find_if(channels.begin(), channels.end(), [&](const ImageChannel& c) { return c.name == name; });
    return it == channels.end() ? nullptr : &*it;
}

ImageChannel* Image::find(std::string_view name) { return const_cast<ImageChannel*>(std::as_const(*this).find(name)); }

const std::vector<float>& Image::get(std::string_view name) const {
    const ImageChannel* c = find(name);
    if (!c) throw CacheError("the picture has no channel '{}'; render it again", name);
    return c->values;
}

std::string encode_png(const Image8& image) {
    THIXO_ASSERT(image.channels == 3 || image.channels == 4, "{} channels", image.channels);
    const std::size_t size = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                             static_cast<std::size_t>(image.channels);
    THIXO_ASSERT(image.width > 0 && image.height > 0 && image.values.size() == size, "{} values for {} x {} pixels",
                 image.values.size(), image.width, image.height);
    png_image png = start(static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height),
                          image.channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB);
    png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string out(bytes, '\0');
    if (!png_image_write_to_memory(&png, out.data(), &bytes, 0, image.values.data(), 0, nullptr))
        throw ResourceError("cannot encode a PNG of {} x {} pixels: {}", image.width, image.height, png.message);
    out.resize(bytes);
    return out;
}

void write_png(const std::filesystem::path& path, const Image8& image) { write_whole(path, encode_png(image)); }

Image8 decode_png(std::string_view bytes, const std::string& file) {
    png_image png = start(0, 0, 0);
    if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()))
        throw CacheError("'{}' is damaged or not a PNG: {}", file, png.message);
    // 16 bits without sRGB or gAMA are coded as 8 bits are: libpng would take them for linear.
    png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
    const bool alpha = (png.format & PNG_FORMAT_FLAG_ALPHA) != 0;
    png.format = alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    Image8 image{static_cast<int>(png.width), static_cast<int>(png.height), alpha ? 4 : 3, {}};
    const std::size_t size =
        static_cast<std::size_t>(png.width) * png.height * static_cast<std::size_t>(image.channels);
    if (png.width > kLargestSide || png.height > kLargestSide || size / kLargestRatio > bytes.size()) {
        png_image_free(&png);
        throw CacheError("'{}' is damaged: it is too short for its size in pixels", file);
    }
    image.values.resize(size);
    if (!png_image_finish_read(&png, nullptr, image.values.data(), 0, nullptr))
        throw CacheError("'{}' is damaged: {}", file, png.message);
    return image;
}

double png_pixels(std::string_view bytes, const std::string& file) {
    png_image png = start(0, 0, 0);
    if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()))
        throw CacheError("'{}' is damaged or not a PNG: {}", file, png.message);
    png_image_free(&png);
    return double(png.width) * double(png.height);
}

Image8 read_png(const std::filesystem::path& path) { return decode_png(read_whole(path), path.string()); }

bool is_own_png(std::string_view bytes) {
    try {
        return encode_png(decode_png(bytes, "")) == bytes;
    } catch (const CacheError&) {
        return false;
    }
}

}  // namespace thixo
