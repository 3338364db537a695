#include "pipeline/contract/image.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

Image sample_image() {
    Image image(37, 23);
    for (const char* name : {"R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z", "albedo.R", "albedo.G", "albedo.B"}) {
        const bool half = std::string(name) != "Z" && name[0] != 'N';
        std::vector<float>& values = image.add(name, half);
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = static_cast<float>(10 * random_unit(1, i, 0, image.channels.size()));
    }
    image.attributes = {{"thixo_frame", "7"}, {"thixo_look", "0123456789abcdef"}};
    return image;
}

std::string refusal(const std::string& bytes, Checksum checksum = Checksum::if_present) {
    return message_of([&] { decode_exr(bytes, "frame.exr", checksum); }, kBadCache);
}

TEST(Exr, KeepsFloatsExactlyAndHalvesToTheirPrecision) {
    const Image image = sample_image();
    const Image read = decode_exr(encode_exr(image), "frame.exr", Checksum::required);
    EXPECT_EQ(read.width, 37);
    EXPECT_EQ(read.height, 23);
    EXPECT_EQ(read.attributes, image.attributes);
    ASSERT_EQ(read.channels.size(), image.channels.size());
    for (const ImageChannel& c : image.channels) {
        const ImageChannel* r = read.find(c.name);
        ASSERT_NE(r, nullptr) << c.name;
        EXPECT_EQ(r->half, c.half);
        for (std::size_t i = 0; i < c.values.size(); ++i) {
            // A half has 11 significant bits: half a unit in the last place is 2^-11 of the value at most (2^-25 below
            // 2^-14).
            const float bound = c.half ? std::max(std::ldexp(c.values[i], -11), std::ldexp(1.0f, -25)) : 0.0f;
            ASSERT_LE(std::abs(r->values[i] - c.values[i]), bound) << c.name << " " << i;
        }
    }
}

TEST(Exr, HalvesAreClampedToTheLargestHalfAndKeepNan) {
    Image image(2, 2);
    image.add("R") = {1e9f, -1e9f, std::numeric_limits<float>::quiet_NaN(), 65504.0f};
    const Image read = decode_exr(encode_exr(image), "frame.exr");
    const auto& r = read.get("R");
    EXPECT_EQ(r[0], 65504.0f);
    EXPECT_EQ(r[1], -65504.0f);
    EXPECT_TRUE(std::isnan(r[2]));
    EXPECT_EQ(r[3], 65504.0f);
}

TEST(Exr, EqualPicturesGiveEqualBytesWithoutADate) {
    const std::string bytes = encode_exr(sample_image());
    EXPECT_EQ(bytes, encode_exr(sample_image()));
    for (const char* word : {"capDate", "Date", "host", "software", "owner"})
        EXPECT_EQ(bytes.find(word), std::string::npos) << word;
}

TEST(Exr, EveryFlippedBitAndEveryTruncationIsFound) {
    Image image(4, 3);
    for (const char* name : {"R", "G", "B"})
        for (float& v : image.add(name)) v = 0.5f;
    const std::string bytes = encode_exr(image);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::string flipped = bytes;
        flipped[i] = static_cast<char>(flipped[i] ^ (1 << (i % 8)));
        ASSERT_NE(refusal(flipped, Checksum::required).find("'frame.exr'"), std::string::npos) << i;
        ASSERT_NE(refusal(bytes.substr(0, i), Checksum::required).find("'frame.exr'"), std::string::npos) << i;
    }
}

TEST(Exr, PicturesOfOtherProgramsAreReadUnlessTruncated) {
    const TemporaryFolder folder;
    const int width = 64, height = 48;
    std::vector<float> values(static_cast<std::size_t>(width * height));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(random_unit(3, i, 0, 0));
    {
        Imf::Header header(width, height);
        header.compression() = Imf::ZIP_COMPRESSION;
        header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
        Imf::FrameBuffer buffer;
        buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 4 * width));
        Imf::OutputFile file((folder / "other.exr").c_str(), header);
        file.setFrameBuffer(buffer);
        file.writePixels(height);
    }
    const std::string bytes = read_whole(folder / "other.exr");
    EXPECT_EQ(decode_exr(bytes, "other.exr").get("Y"), values);
    EXPECT_NE(refusal(bytes, Checksum::required).find("no checksum"), std::string::npos);
    for (std::size_t length = 0; length < bytes.size(); length += 37)
        ASSERT_NE(refusal(bytes.substr(0, length)).find("'frame.exr' is damaged or not an EXR"), std::string::npos)
            << length;
}

TEST(Exr, CropsAreReadInTheirPlaceInTheWholePicture) {
    const TemporaryFolder folder;
    const auto read = [&](const Imath::Box2i& display, const Imath::Box2i& data) {
        const int width = data.max.x - data.min.x + 1, height = data.max.y - data.min.y + 1;
        std::vector<float> values;
        for (int y = data.min.y; y <= data.max.y; ++y)
            for (int x = data.min.x; x <= data.max.x; ++x) values.push_back(static_cast<float>(100 * y + x));
        Imf::Header header(display, data);
        header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
        Imf::FrameBuffer buffer;
        char* base = reinterpret_cast<char*>(values.data() - data.min.x - std::ptrdiff_t(data.min.y) * width);
        buffer.insert("Y", Imf::Slice(Imf::FLOAT, base, 4, 4 * static_cast<std::size_t>(width)));
        {
            Imf::OutputFile file((folder / "crop.exr").c_str(), header);
            file.setFrameBuffer(buffer);
            file.writePixels(height);
        }
        return read_exr(folder / "crop.exr");
    };
    const auto window = [](int x0, int y0, int x1, int y1) {
        return Imath::Box2i(Imath::V2i(x0, y0), Imath::V2i(x1, y1));
    };
    const Imath::Box2i display = window(3, 5, 12, 10);
    // A crop, one that reaches beyond on all sides, one that lies aside.
    for (const Imath::Box2i& data : {window(4, 6, 7, 9), window(0, 0, 20, 20), window(30, 5, 40, 10)}) {
        const Image image = read(display, data);
        ASSERT_EQ(image.width, 10);
        ASSERT_EQ(image.height, 6);
        for (int y = 5; y <= 10; ++y)
            for (int x = 3; x <= 12; ++x)
                EXPECT_EQ(image.get("Y")[static_cast<std::size_t>((y - 5) * 10 + x - 3)],
                          data.intersects(Imath::V2i(x, y)) ? static_cast<float>(100 * y + x) : 0.0f);
    }
}

TEST(Exr, ACropOfAVastPictureIsRefusedBeforeItTakesMemory) {
    const TemporaryFolder folder;
    const float value = 1;
    Imf::Header header(Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(30000, 30000)),
                       Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(0, 0)));
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    {
        Imf::FrameBuffer buffer;
        buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(&value)), 4, 4));
        Imf::OutputFile file((folder / "vast.exr").c_str(), header);
        file.setFrameBuffer(buffer);
        file.writePixels(1);
    }
    const std::string bytes = read_whole(folder / "vast.exr");
    EXPECT_NE(refusal(bytes).find("too short for its display window"), std::string::npos) << refusal(bytes);
    EXPECT_EQ(exr_pixels(bytes, "vast.exr"), 30001.0 * 30001.0) << "what it would take in memory";
}

TEST(Exr, AnAttributeOfMoreBytesThanTheFileIsRefusedBeforeItTakesMemory) {
    Image image(4, 3);
    image.add("R");
    std::string bytes = encode_exr(image);
    bytes.replace(bytes.find("thixo_checksum"), 14, "other_checksum");  // another program's
    const std::int32_t most = std::numeric_limits<std::int32_t>::max();
    for (const char* type : {"string", "v2f", "chlist"}) {
        std::string hostile = bytes;
        std::memcpy(hostile.data() + hostile.find(std::string(type) + '\0') + std::strlen(type) + 1, &most,
                    sizeof most);
        EXPECT_NE(refusal(hostile).find("claims more bytes than the file has"), std::string::npos) << refusal(hostile);
    }
}

TEST(Exr, HostileHeadersAreRefusedSoon) {
    Image image(64, 64);
    image.add("R");
    std::string bytes = encode_exr(image);
    // Another name for the checksum makes it another program's picture; then every value of the header may lie.
    bytes.replace(bytes.find("thixo_checksum"), 14, "other_checksum");
    const std::size_t window = bytes.find("dataWindow") + 11 + 6 + 4;
    for (std::uint64_t k = 0; k < 300; ++k) {
        std::string hostile = bytes;
        for (std::size_t i = 0; i < 16; ++i)
            if (random_bits(5, k, i, 0) % 2) hostile[window + i] = static_cast<char>(random_bits(5, k, i, 1));
        const std::size_t at = random_bits(5, k, 99, 0) % 350;
        hostile[at] = static_cast<char>(random_bits(5, k, 99, 1));
        try {
            decode_exr(hostile, "frame.exr");
        } catch (const CacheError&) {
        }
    }
}

TEST(Exr, AFullDiskLeavesTheOldPicture) {
    const TemporaryFolder folder;
    write_exr(folder / "f.exr", sample_image());
    const std::string old = read_whole(folder / "f.exr");
    const int status = in_child("1:1000:enospc", [&] {
        Image other(8, 8);
        other.add("R");
        write_exr(folder / "f.exr", other);
        return 0;
    });
    EXPECT_EQ(WEXITSTATUS(status), kNoResource);
    EXPECT_EQ(read_whole(folder / "f.exr"), old);
    EXPECT_EQ(read_exr(folder / "f.exr", Checksum::required).width, 37);
}

TEST(Exr, AMissingChannelIsNamed) {
    const Image image = sample_image();
    EXPECT_NE(message_of([&] { image.get("variance.R"); }, kBadCache).find("'variance.R'"), std::string::npos);
}

TEST(Png, ComesBackAsItWas) {
    const TemporaryFolder folder;
    for (const int channels : {3, 4}) {
        Image8 image{19, 11, channels, {}};
        for (int i = 0; i < 19 * 11 * channels; ++i)
            image.values.push_back(static_cast<std::uint8_t>(random_bits(2, static_cast<std::uint64_t>(i), 0, 0)));
        write_png(folder / "p.png", image);
        const Image8 read = read_png(folder / "p.png");
        EXPECT_EQ(read.width, 19);
        EXPECT_EQ(read.height, 11);
        EXPECT_EQ(read.channels, channels);
        EXPECT_EQ(read.values, image.values);
        EXPECT_EQ(encode_png(image), encode_png(image));
        EXPECT_EQ(encode_png(image).find("tIME"), std::string::npos);
    }
}

/// One pixel of 8 or 16 bits a channel as a PNG without sRGB or gAMA, or with a gAMA of its own.
std::string foreign_png(int type, int bits, const std::vector<std::uint8_t>& pixel, double gamma = 0) {
    std::string bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(
        png, &bytes,
        [](png_structp p, png_bytep data, png_size_t size) {
            static_cast<std::string*>(png_get_io_ptr(p))->append(reinterpret_cast<char*>(data), size);
        },
        nullptr);
    png_set_IHDR(png, info, 1, 1, bits, type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    if (gamma > 0) png_set_gAMA(png, info, gamma);
    png_write_info(png, info);
    png_write_row(png, pixel.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return bytes;
}

TEST(Png, OfSixteenBitsHasTheColoursOfItsTwinOfEight) {
    const std::vector<std::uint8_t> shades{229, 50, 26, 128};
    for (const auto& [type, channels] : {std::pair{PNG_COLOR_TYPE_GRAY, 1},
                                         {PNG_COLOR_TYPE_GRAY_ALPHA, 2},
                                         {PNG_COLOR_TYPE_RGB, 3},
                                         {PNG_COLOR_TYPE_RGB_ALPHA, 4}}) {
        std::vector<std::uint8_t> eight(shades.begin(), shades.begin() + channels), sixteen;
        for (const std::uint8_t v : eight) sixteen.insert(sixteen.end(), {v, v});  // v/255 = 257 v/65535
        const Image8 a = decode_png(foreign_png(type, 8, eight), "8.png"),
                     b = decode_png(foreign_png(type, 16, sixteen), "16.png");
        EXPECT_EQ(a.values, b.values) << channels;
        EXPECT_EQ(a.values[0], shades[0]);
    }
    // What says that it is linear is decoded so; libpng takes sRGB for the power 1/2.2 there.
    EXPECT_NEAR(decode_png(foreign_png(PNG_COLOR_TYPE_RGB, 16, {128, 0, 128, 0, 128, 0}, 1.0), "l.png").values[0],
                255 * std::pow(32768 / 65535.0, 1 / 2.2), 1);
}

TEST(Png, DamageIsNamed) {
    const TemporaryFolder folder;
    Image8 image{64, 64, 3, {}};
    for (std::uint64_t i = 0; i < 64 * 64 * 3; ++i)
        image.values.push_back(static_cast<std::uint8_t>(random_bits(2, i, 0, 0)));
    const std::string bytes = encode_png(image);
    for (std::size_t length = 0; length + 12 < bytes.size();
         length += 501) {  // its last 12 bytes only say that it ends
        write_whole(folder / "p.png", bytes.substr(0, length));
        ASSERT_NE(message_of([&] { read_png(folder / "p.png"); }, kBadCache).find("p.png"), std::string::npos)
            << length;
    }
}

}  // namespace
}  // namespace thixo::test
