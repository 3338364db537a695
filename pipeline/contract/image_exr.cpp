#include <ImfAttribute.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/image.h"

namespace thixo {
namespace {

constexpr const char* kChecksumKey = "thixo_checksum";
constexpr std::size_t kDigits = 32;
// Of deflate: pixels that need more bytes than this times the file cannot be in it.
constexpr std::size_t kLargestShrink = 1100;
constexpr double kMostBlank = 1 << 26;  // values of a picture of which a file of few bytes may hold a crop: 256 MiB
constexpr std::int64_t kMostPixels = 1 << 28;
constexpr int kLongestSide = 1 << 20;

class MemoryOut : public Imf::OStream {
  public:
    MemoryOut() : Imf::OStream("memory") {}
    void write(const char c[], int n) override {
        const auto count = static_cast<std::size_t>(n);
        if (at_ + count > bytes.size()) bytes.resize(at_ + count);
        std::memcpy(bytes.data() + at_, c, count);
        at_ += count;
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t pos) override { at_ = pos; }
    std::string bytes;

  private:
    std::size_t at_ = 0;
};

class MemoryIn : public Imf::IStream {
  public:
    MemoryIn(std::string_view bytes, const char* name) : Imf::IStream(name), bytes_(bytes) {}
    bool read(char c[], int n) override {
        const auto count = static_cast<std::size_t>(n);
        if (n < 0 || at_ > bytes_.size() || count > bytes_.size() - at_) throw std::runtime_error("it ends early");
        std::memcpy(c, bytes_.data() + at_, count);
        at_ += count;
        return at_ < bytes_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t pos) override { at_ = pos; }

  private:
    std::string_view bytes_;
    std::size_t at_ = 0;
};

/// Where the digits of the checksum attribute stand in the header, or npos. An attribute is: name, 0, type, 0, size (4
/// bytes), value.
std::size_t checksum_at(std::string_view bytes) {
    std::string mark = std::string(kChecksumKey) + '\0' + "string" + '\0';
    mark += {static_cast<char>(kDigits), 0, 0, 0};
    const std::size_t at = bytes.find(mark);
    return at == std::string_view::npos || at + mark.size() + kDigits > bytes.size() ? std::string_view::npos
                                                                                     : at + mark.size();
}

Imf::Header make_header(const Image& image) {
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    for (const ImageChannel& c : image.channels)
        header.channels().insert(c.name, Imf::Channel(c.half ? Imf::HALF : Imf::FLOAT));
    for (const auto& [key, text] : image.attributes) header.insert(key, Imf::StringAttribute(text));
    header.insert(kChecksumKey, Imf::StringAttribute(std::string(kDigits, '0')));
    return header;
}

/// Too large for half becomes its largest number, not infinity: an infinite pixel spoils every filter after it.
Imath::half to_half(float v) { return Imath::half(std::isfinite(v) ? std::clamp(v, -65504.0f, 65504.0f) : v); }

void write_pixels(const Image& image, Imf::OStream& out) {
    const std::size_t width = static_cast<std::size_t>(image.width);
    std::vector<std::vector<Imath::half>> halves(image.channels.size());
    Imf::FrameBuffer buffer;
    for (std::size_t i = 0; i < image.channels.size(); ++i) {
        const ImageChannel& c = image.channels[i];
        if (c.half) {
            halves[i].resize(image.pixels());
            std::transform(c.values.begin(), c.values.end(), halves[i].begin(), to_half);
            buffer.insert(c.name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves[i].data()), sizeof(Imath::half),
                                             sizeof(Imath::half) * width));
        } else {
            char* base = reinterpret_cast<char*>(const_cast<float*>(c.values.data()));  // an OutputFile only reads it
            buffer.insert(c.name, Imf::Slice(Imf::FLOAT, base, sizeof(float), sizeof(float) * width));
        }
    }
    Imf::OutputFile file(out, make_header(image));
    file.setFrameBuffer(buffer);
    file.writePixels(image.height);
}

/// A picture of zeros of a window's size.
Image blank(const Imath::Box2i& window) {
    const auto width = std::int64_t(window.max.x) - window.min.x + 1,
               height = std::int64_t(window.max.y) - window.min.y + 1;
    if (width < 1 || height < 1 || width > kLongestSide || height > kLongestSide || width * height > kMostPixels)
        throw std::runtime_error("its size is out of range");
    return {static_cast<int>(width), static_cast<int>(height)};
}

double pixels_of(const Imath::Box2i& window) {
    return (double(window.max.x) - window.min.x + 1) * (double(window.max.y) - window.min.y + 1);
}

/// The picture that is shown: what a crop leaves out is black, what reaches beyond is cut off. A file of few bytes may
/// not ask for much of it.
Image placed(const Image& data, const Imath::Box2i& data_window, const Imath::Box2i& display_window,
             std::size_t file_size) {
    const double values = pixels_of(display_window) * double(data.channels.size());
    if (values > std::max(kMostBlank, double(kLargestShrink) / sizeof(Imath::half) * double(file_size)))
        throw std::runtime_error("it is too short for its display window");
    Image shown = blank(display_window);
    shown.attributes = data.attributes;
    const Imath::V2i lower(std::max(data_window.min.x, display_window.min.x),
                           std::max(data_window.min.y, display_window.min.y)),
        upper(std::min(data_window.max.x, display_window.max.x), std::min(data_window.max.y, display_window.max.y));
    for (const ImageChannel& from : data.channels) {
        std::vector<float>& to = shown.add(from.name, from.half);
        for (int y = lower.y; y <= upper.y && lower.x <= upper.x; ++y)
            std::copy_n(from.values.begin() + (y - data_window.min.y) * std::ptrdiff_t(data.width) +
                            (lower.x - data_window.min.x),
                        upper.x - lower.x + 1,
                        to.begin() + (y - display_window.min.y) * std::ptrdiff_t(shown.width) +
                            (lower.x - display_window.min.x));
    }
    return shown;
}

/// Throws where an attribute claims more bytes than the file has. The library would make room for them before it reads.
/// It also makes a table of a picture's rows, so that it gets their limit.
void require_header_sizes(std::string_view bytes) {
    constexpr std::size_t kStart = 8;  // magic number and version
    constexpr unsigned char kManyParts = 0x10;
    static const bool limited = [] {
        Imf::Header::setMaxImageSize(kLongestSide, kLongestSide);
        return true;
    }();
    if (!limited || bytes.size() < kStart) return;
    std::size_t at = kStart;
    const auto skip_text = [&] {  // a name or a type; false where it is empty
        const std::size_t end = bytes.find('\0', at);
        if (end == std::string_view::npos) throw std::runtime_error("its header is cut short");
        const bool empty = end == at;
        at = end + 1;
        return !empty;
    };
    const bool many = (static_cast<unsigned char>(bytes[5]) & kManyParts) != 0;
    do {
        while (skip_text()) {
            skip_text();
            std::int32_t size = 0;
            if (bytes.size() - at < sizeof size) throw std::runtime_error("its header is cut short");
            std::memcpy(&size, bytes.data() + at, sizeof size);
            at += sizeof size;
            if (size < 0 || static_cast<std::size_t>(size) > bytes.size() - at)
                throw std::runtime_error("an attribute claims more bytes than the file has");
            at += static_cast<std::size_t>(size);
        }
    } while (many && at < bytes.size() && bytes[at] != '\0');
}

Image read_pixels(std::string_view bytes, const std::string& name) {
    require_header_sizes(bytes);
    MemoryIn in(bytes, name.c_str());
    Imf::InputFile file(in);
    if (!file.isComplete()) throw std::runtime_error("its writer did not finish");
    const Imf::Header& header = file.header();
    const Imath::Box2i window = header.dataWindow();
    Image image = blank(window);
    const int width = image.width;
    std::size_t stored = 0;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
            throw std::runtime_error("a channel is subsampled");
        stored += image.pixels() * (c.channel().type == Imf::HALF ? 2 : 4);
    }
    if (stored / kLargestShrink > bytes.size()) throw std::runtime_error("it is too short for its size in pixels");
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        image.add(c.name(), c.channel().type == Imf::HALF);
    Imf::FrameBuffer buffer;
    const std::ptrdiff_t origin = window.min.x + window.min.y * static_cast<std::ptrdiff_t>(width);
    for (ImageChannel& c : image.channels)  // the library converts half to float
        buffer.insert(c.name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(c.values.data() - origin), sizeof(float),
                                         sizeof(float) * width));
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    for (auto a = header.begin(); a != header.end(); ++a)
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute());
            text && std::strcmp(a.name(), kChecksumKey) != 0)
            image.attributes[a.name()] = text->value();
    return header.displayWindow() == window ? image : placed(image, window, header.displayWindow(), bytes.size());
}

}  // namespace

std::string encode_exr(const Image& image) {
    THIXO_ASSERT(image.width > 0 && image.height > 0 && !image.channels.empty(), "{} x {} pixels, {} channels",
                 image.width, image.height, image.channels.size());
    for (const ImageChannel& c : image.channels)
        THIXO_ASSERT(c.values.size() == image.pixels(), "channel {} has {} values for {} pixels", c.name,
                     c.values.size(), image.pixels());
    MemoryOut out;
    write_pixels(image, out);
    const std::size_t at = checksum_at(out.bytes);
    THIXO_ASSERT(at != std::string::npos, "the header lost its checksum");
    out.bytes.replace(at, kDigits, hash_hex(out.bytes));
    return std::move(out.bytes);
}

void write_exr(const std::filesystem::path& path, const Image& image) { write_whole(path, encode_exr(image)); }

double exr_pixels(std::string_view bytes, const std::string& file) {
    try {
        require_header_sizes(bytes);
        MemoryIn in(bytes, file.c_str());
        const Imf::InputFile read(in);
        return std::max(pixels_of(read.header().dataWindow()), pixels_of(read.header().displayWindow()));
    } catch (const std::exception& e) {
        throw CacheError("'{}' is damaged or not an EXR", file);
    }
}

bool is_own_exr(std::string_view bytes) {
    constexpr std::size_t kHeader = 1 << 16;
    return bytes.substr(0, kHeader).find("thixo") != std::string_view::npos;
}

Image decode_exr(std::string_view bytes, const std::string& file, Checksum checksum) {
    const std::size_t at = checksum_at(bytes);
    if (at == std::string_view::npos && checksum == Checksum::required)
        throw CacheError("'{}' is damaged or was not written by Thixo: it has no checksum", file);
    if (at != std::string_view::npos && bytes.substr(at, kDigits) != hash_hex_without(bytes, at, kDigits))
        throw CacheError("'{}' is damaged: its checksum does not match", file);
    try {
        return read_pixels(bytes, file);
    } catch (const std::exception& e) {  // OpenEXR throws its own types and bad_alloc on damage
        std::string reason = e.what();
        std::replace(reason.begin(), reason.end(), '\n', ' ');
        throw CacheError("'{}' is damaged or not an EXR: {}", file, reason);
    }
}

Image read_exr(const std::filesystem::path& path, Checksum checksum) {
    return decode_exr(read_whole(path), path.string(), checksum);
}

}  // namespace thixo
