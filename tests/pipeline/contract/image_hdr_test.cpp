// Radiance HDR: the same picture in each way that it can be stored.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "pipeline/contract/image.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

constexpr int kWide = 12, kHigh = 3;
using Rgbe = std::array<unsigned char, 4>;

/// Pixels with runs in them. None is 1 1 1 n, which flat lines have another use for.
Rgbe pixel(int x, int y) {
    if (x < 5) return {200, 100, 50, static_cast<unsigned char>(128 + y)};
    return {static_cast<unsigned char>(128 + 10 * y + x), 3, static_cast<unsigned char>(20 * x), 130};
}

std::string header(const std::string& size, const std::string& more = "") {
    return "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\n" + more + "\n" + size + "\n";
}

std::string text(const Rgbe& p) { return {p.begin(), p.end()}; }

std::string flat(const std::string& head) {
    std::string bytes = head;
    for (int y = 0; y < kHigh; ++y)
        for (int x = 0; x < kWide; ++x) bytes += text(pixel(x, y));
    return bytes;
}

std::string hdr_refusal(const std::string& bytes) {
    return message_of([&] { decode_hdr(bytes, "sky.hdr"); }, kBadCache);
}

void expect_picture(const Image& image, double factor = 1) {
    ASSERT_EQ(image.width, kWide);
    ASSERT_EQ(image.height, kHigh);
    for (int y = 0; y < kHigh; ++y)
        for (int x = 0; x < kWide; ++x)
            for (std::size_t c = 0; c < 3; ++c) {
                const Rgbe p = pixel(x, y);
                EXPECT_FLOAT_EQ(image.channels[c].values[static_cast<std::size_t>(y * kWide + x)],
                                static_cast<float>(factor * (p[c] + 0.5) * std::pow(2.0, p[3] - 136)))
                    << x << ' ' << y << ' ' << c;
            }
}

const std::string kSize = "-Y 3 +X 12";

TEST(Hdr, OfFlatLinesIsReadAsWritten) {
    expect_picture(decode_hdr(flat(header(kSize)), "sky.hdr"));
    EXPECT_EQ(hdr_pixels(flat(header(kSize)), "sky.hdr"), kWide * kHigh);
}

TEST(Hdr, OfPackedComponentsIsTheSame) {
    std::string bytes = header(kSize);
    for (int y = 0; y < kHigh; ++y) {
        bytes += {2, 2, 0, kWide};
        for (std::size_t c = 0; c < 4; ++c) {
            bytes += {static_cast<char>(128 + 5), static_cast<char>(pixel(0, y)[c]), kWide - 5};
            for (int x = 5; x < kWide; ++x) bytes += static_cast<char>(pixel(x, y)[c]);
        }
    }
    expect_picture(decode_hdr(bytes, "sky.hdr"));
}

TEST(Hdr, OfRepeatedPixelsIsTheSame) {
    std::string bytes = header(kSize);
    for (int y = 0; y < kHigh; ++y) {
        bytes += text(pixel(0, y)) + text({1, 1, 1, 4});
        for (int x = 5; x < kWide; ++x) bytes += text(pixel(x, y));
    }
    expect_picture(decode_hdr(bytes, "sky.hdr"));
    // 300 of one: 44 and 256 times 1 more, less the pixel itself.
    const Image long_run =
        decode_hdr(header("-Y 1 +X 301") + text({9, 8, 7, 136}) + text({1, 1, 1, 44}) + text({1, 1, 1, 1}), "sky.hdr");
    for (const float v : long_run.get("G")) EXPECT_EQ(v, 8.5f);
}

TEST(Hdr, InAnyOrderIsTurnedUpright) {
    const auto stored = [](const std::string& size, auto&& place) {
        std::string bytes = header(size);
        const bool by_lines = size[1] == 'Y';
        for (int a = 0; a < (by_lines ? kHigh : kWide); ++a)
            for (int b = 0; b < (by_lines ? kWide : kHigh); ++b) {
                const auto [x, y] = place(a, b);
                bytes += text(pixel(x, y));
            }
        return decode_hdr(bytes, "sky.hdr");
    };
    using Place = std::pair<int, int>;
    expect_picture(stored("+Y 3 +X 12", [](int a, int b) { return Place(b, kHigh - 1 - a); }));
    expect_picture(stored("-Y 3 -X 12", [](int a, int b) { return Place(kWide - 1 - b, a); }));
    expect_picture(stored("+X 12 -Y 3", [](int a, int b) { return Place(a, b); }));
    expect_picture(stored("-X 12 +Y 3", [](int a, int b) { return Place(kWide - 1 - a, kHigh - 1 - b); }));
}

TEST(Hdr, OfAnExposureHasTheLightOfTheScene) {
    expect_picture(decode_hdr(flat(header(kSize, "EXPOSURE=4\nEXPOSURE= 0.5\nCOLORCORR=2 2 2\n")), "sky.hdr"), 0.25);
    expect_picture(decode_hdr(flat(header(kSize, "PRIMARIES=0.64 0.33 0.29 0.6 0.15 0.06 0.333 0.333\n")), "sky.hdr"));
    EXPECT_EQ(decode_hdr(header("-Y 1 +X 1") + text({9, 9, 9, 0}), "sky.hdr").get("R")[0], 0.0f);
}

TEST(Hdr, ThatIsDamagedOrOfAnotherKindIsRefused) {
    const std::string good = flat(header(kSize));
    const std::pair<std::string, const char*> bad[] = {
        {"", "does not begin with #?"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe", "its header has no end"},
        {"#?RADIANCE\n\n-Y 3 +X 12\n", "does not state its FORMAT"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 3 +X 12\n", "not 32-bit_rle_rgbe"},
        {flat(header(kSize, "EXPOSURE=0\n")), "exposure is not above 0"},
        {flat(header(kSize, "EXPOSURE=bright\n")), "a number of its header is none"},
        {flat(header(kSize, "COLORCORR=1 1\n")), "a number of its header is none"},
        {flat(header(kSize, "PRIMARIES=0.7 0.3 0.2 0.7 0.1 0.1 0.3 0.3\n")), "PRIMARIES are not those of Rec.709"},
        {flat(header("-Y 3 -Y 12")), "does not state its size"},
        {flat(header("3 12")), "does not state its size"},
        {flat(header("-Y 3 +X 0")), "does not state its size"},
        {flat(header("-Y 3 +X 99999999999")), "does not state its size"},
        {flat(header("-Y 90000 +X 90000")), "too short for its size"},
        {header(kSize) + text({1, 1, 1, 3}), "a run leaves its scan line"},
        {header(kSize) + text({9, 9, 9, 128}) + text({1, 1, 1, 12}), "a run leaves its scan line"},
        {header(kSize) + text({2, 2, 0, 13}), "another length"},
        {header(kSize) + text({2, 2, 0, 12}) + text({128 + 13, 0, 0, 0}), "a run leaves its scan line"},
    };
    for (const auto& [bytes, reason] : bad) EXPECT_NE(hdr_refusal(bytes).find(reason), std::string::npos) << reason;
    const std::size_t body = header(kSize).size();
    for (std::size_t length = 0; length < good.size(); ++length)
        EXPECT_NE(hdr_refusal(good.substr(0, length)).find(length < body ? "damaged" : "ends early"), std::string::npos)
            << length;
}

}  // namespace
}  // namespace thixo::test
