// Pictures: scene-linear EXR with named float channels, and 8-bit PNG. Radiance HDR and JPEG are read, too.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace thixo {

/// One channel, row-major from the top left; `half` is how it is stored, in memory it is float.
struct ImageChannel {
    std::string name;  // R G B A Z, or <layer>.<R G B | X Y Z>: give layers 3 or 4 channels, Blender drops layers of 2
    bool half = true;
    std::vector<float> values;  // width * height
};

struct Image {
    int width = 0, height = 0;
    std::vector<ImageChannel> channels;
    std::map<std::string, std::string> attributes;  // text in the header; must not vary between equal runs

    Image() = default;
    Image(int w, int h) : width(w), height(h) {}
    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    /// A new channel of zeros. References to other channels' values become invalid.
    std::vector<float>& add(std::string name, bool half = true);
    const ImageChannel* find(std::string_view name) const;
    ImageChannel* find(std::string_view name);
    /// Throws CacheError naming a channel that is not there.
    const std::vector<float>& get(std::string_view name) const;
};

/// Scene-linear Rec.709, ZIP, one part, with a checksum of the whole file in its header. Channels are stored sorted by
/// name.
std::string encode_exr(const Image& image);
/// encode_exr, written whole (atomic_file.h). Throws ResourceError.
void write_exr(const std::filesystem::path& path, const Image& image);

/// Whether a file without Thixo's checksum (another program's) is accepted.
enum class Checksum { required, if_present };
/// Reads and decodes every pixel of the display window, black where the data window leaves it out; `file` is named in
/// messages. Throws CacheError: missing, truncated, damaged, not an EXR.
Image decode_exr(std::string_view bytes, const std::string& file, Checksum checksum = Checksum::if_present);
Image read_exr(const std::filesystem::path& path, Checksum checksum = Checksum::if_present);

/// Whether the header has attributes of Thixo's, be the file damaged or not.
bool is_own_exr(std::string_view bytes);

/// Pixels as the header states them. Throws CacheError where it cannot be read.
double exr_pixels(std::string_view bytes, const std::string& file);
double png_pixels(std::string_view bytes, const std::string& file);

/// A Radiance HDR: float channels R, G and B. Throws CacheError: truncated, damaged, not of this kind.
///
/// - flat scan lines and both kinds of run lengths are read; lines may be stored in any order
/// - values are divided by all EXPOSURE and COLORCORR in the header
/// - XYZE, and PRIMARIES far from those of Rec.709, are refused
Image decode_hdr(std::string_view bytes, const std::string& file);
double hdr_pixels(std::string_view bytes, const std::string& file);

/// 8 bits a channel, sRGB, alpha (if any) not premultiplied; row-major from the top left.
struct Image8 {
    int width = 0, height = 0, channels = 3;  // 3: RGB, 4: RGBA
    std::vector<std::uint8_t> values;         // width * height * channels
};

std::string encode_png(const Image8& image);
/// encode_png, written whole (atomic_file.h). Throws ResourceError.
void write_png(const std::filesystem::path& path, const Image8& image);
/// `file` is named in messages. Throws CacheError: damaged, not a PNG. More than 8 bits a channel are rounded to 8,
/// grey becomes RGB. Without sRGB or gAMA the values are taken for sRGB, at any depth.
Image8 decode_png(std::string_view bytes, const std::string& file);
/// Throws CacheError: missing, damaged, not a PNG.
Image8 read_png(const std::filesystem::path& path);

/// A JPEG of grey or YCbCr pixels, 8 bits a channel, as RGB. Throws CacheError: damaged, not a JPEG, of four colours.
Image8 decode_jpeg(std::string_view bytes, const std::string& file);
double jpeg_pixels(std::string_view bytes, const std::string& file);

/// Whether the bytes are what encode_png makes of the picture that they hold.
bool is_own_png(std::string_view bytes);

}  // namespace thixo
