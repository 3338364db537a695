// JPEG: what libjpeg's encoder makes of a picture comes back near to it, and damage is named.
#include <gtest/gtest.h>

#include <cstdio>
// This header needs that one.
#include <jpeglib.h>

#include <cmath>
#include <cstdlib>

#include "pipeline/contract/image.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

constexpr int kAcross = 45, kDown = 30;  // no whole number of blocks

std::uint8_t shade(int x, int y, int c) {
    return static_cast<std::uint8_t>(128 + 100 * std::sin(0.1 * x + 0.07 * y + 2 * c));
}

struct Form {
    int components = 3;
    J_COLOR_SPACE colours = JCS_RGB;
    bool progressive = false;
    int bits = 0;  // a scan for each of them and each of 64 coefficients; 0: as the encoder likes
};

std::string jpeg(const Form& form) {
    jpeg_compress_struct compress{};
    jpeg_error_mgr errors{};
    compress.err = jpeg_std_error(&errors);
    jpeg_create_compress(&compress);
    unsigned char* out = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&compress, &out, &size);
    compress.image_width = kAcross;
    compress.image_height = kDown;
    compress.input_components = form.components;
    compress.in_color_space = form.colours;
    jpeg_set_defaults(&compress);
    jpeg_set_quality(&compress, 98, TRUE);
    if (form.progressive) jpeg_simple_progression(&compress);
    std::vector<jpeg_scan_info> script;  // of grey pixels: every coefficient by itself, bit after bit
    for (int coefficient = 0; form.bits > 0 && coefficient < 64; ++coefficient)
        for (int bit = form.bits - 1; bit >= 0; --bit)
            script.push_back({1, {0}, coefficient, coefficient, bit == form.bits - 1 ? 0 : bit + 1, bit});
    if (form.bits > 0) {
        compress.scan_info = script.data();
        compress.num_scans = static_cast<int>(script.size());
    }
    jpeg_start_compress(&compress, TRUE);
    std::vector<JSAMPLE> row(static_cast<std::size_t>(kAcross * form.components));
    for (int y = 0; y < kDown; ++y) {
        for (int k = 0; k < kAcross * form.components; ++k)
            row[static_cast<std::size_t>(k)] = shade(k / form.components, y, k % form.components);
        JSAMPROW rows = row.data();
        jpeg_write_scanlines(&compress, &rows, 1);
    }
    jpeg_finish_compress(&compress);
    const std::string bytes(reinterpret_cast<char*>(out), size);
    jpeg_destroy_compress(&compress);
    std::free(out);
    return bytes;
}

std::string jpeg_refusal(const std::string& bytes) {
    return message_of([&] { decode_jpeg(bytes, "wood.jpg"); }, kBadCache);
}

TEST(Jpeg, ComesBackNearToWhatWasPackedIntoIt) {
    for (const Form& form : {Form{}, Form{.progressive = true}, Form{.components = 1, .colours = JCS_GRAYSCALE}}) {
        const std::string bytes = jpeg(form);
        const Image8 image = decode_jpeg(bytes, "wood.jpg");
        ASSERT_EQ(image.width, kAcross);
        ASSERT_EQ(image.height, kDown);
        ASSERT_EQ(image.channels, 3);
        EXPECT_EQ(jpeg_pixels(bytes, "wood.jpg"), kAcross * kDown);
        double squares = 0;
        for (int k = 0; k < 3 * kAcross * kDown; ++k) {
            const int c = form.components == 1 ? 0 : k % 3, x = k / 3 % kAcross, y = k / 3 / kAcross;
            squares += std::pow(double(image.values[static_cast<std::size_t>(k)]) - shade(x, y, c), 2);
        }
        // Of such a smooth picture a quality of 98 keeps every value to about 2 of 255; colours have half the pixels.
        EXPECT_LT(std::sqrt(squares / (3.0 * kAcross * kDown)), 4) << form.components << form.progressive;
    }
}

TEST(Jpeg, ThatIsDamagedOrOfAnotherKindIsRefused) {
    const std::string good = jpeg({});
    for (std::size_t length = 0; length < good.size(); length += 7)
        EXPECT_NE(jpeg_refusal(good.substr(0, length)).find("'wood.jpg' is damaged"), std::string::npos) << length;
    EXPECT_NE(jpeg_refusal("\xff\xd8\xff nothing").find("damaged or not a JPEG"), std::string::npos);
    EXPECT_NE(jpeg_refusal(jpeg({.components = 4, .colours = JCS_CMYK})).find("has 4 components"), std::string::npos);
    // The frame header of another size: width and height stand 7 bytes behind its marker.
    std::string vast = good;
    const std::size_t frame = vast.find("\xff\xc0");
    ASSERT_NE(frame, std::string::npos);
    for (std::size_t k = 5; k < 9; ++k) vast[frame + k] = '\xf0';
    EXPECT_NE(jpeg_refusal(vast).find("too short for its size"), std::string::npos);
}

TEST(Jpeg, OfMoreScansThanAnyoneNeedsIsRefused) {
    // Each of them goes over all pixels: a small file could take hours.
    const Form grey{.components = 1, .colours = JCS_GRAYSCALE};
    const auto of_bits = [&](int bits) {
        Form form = grey;
        form.bits = bits;
        return jpeg(form);
    };
    EXPECT_EQ(decode_jpeg(of_bits(7), "wood.jpg").values, decode_jpeg(jpeg(grey), "wood.jpg").values);  // 448
    EXPECT_NE(jpeg_refusal(of_bits(8)).find("more than 500 scans"), std::string::npos);                 // 512
}

}  // namespace
}  // namespace thixo::test
