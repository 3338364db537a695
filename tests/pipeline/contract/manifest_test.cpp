#include "pipeline/contract/manifest.h"

#include <gtest/gtest.h>

#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

CacheFile file(const std::string& name) { return {name, name.size() * 1000, hash_hex(name)}; }

Manifest sample() {
    Manifest m;
    m.scene = "pour";
    m.scene_text = "scene: pour\n# \"quotes\", tabs\t and \xc3\xa4\n";
    m.simulation_hash = "0123";
    m.assets = {{asset_file_name(hash_hex("mesh")), 4, hash_hex("mesh")}};
    for (const int n : {1, 2, 10'000})
        m.frames.push_back(
            {n, n / 24.0, 5, 6, file(particle_file_name(n)), file(surfel_file_name(n)), file(facts_file_name(n))});
    return m;
}

/// The text with one replacement and a checksum that fits again: damage that only the content can tell.
std::string edited(const std::string& from, const std::string& to) {
    std::string text = print_manifest(sample());
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const std::size_t digits = text.find("\"checksum\": \"") + 13;
    return text.replace(digits, 32, hash_hex_without(text, digits, 32));
}

std::string refusal(const std::string& text) {
    return message_of([&] { parse_manifest(text, "manifest.json"); }, kBadCache);
}

TEST(Manifest, ComesBackAsItWas) {
    const Manifest m = sample();
    EXPECT_EQ(parse_manifest(print_manifest(m), "manifest.json"), m);
    EXPECT_EQ(print_manifest(parse_manifest(print_manifest(m), "manifest.json")), print_manifest(m));
    Manifest bare;
    bare.scene = "bare";
    EXPECT_EQ(parse_manifest(print_manifest(bare), "manifest.json"), bare);
}

TEST(Manifest, FindsFramesByNumber) {
    const Manifest m = sample();
    EXPECT_EQ(m.find(2), &m.frames[1]);
    EXPECT_EQ(m.find(3), nullptr);
    EXPECT_EQ(m.find(10'001), nullptr);
}

TEST(Manifest, ANewerFormatIsRefusedByNumber) {
    const std::string message = "has cache format 99, this program reads 1 to 4";
    EXPECT_NE(refusal(edited("\"format\": 1", "\"format\": 99")).find(message), std::string::npos);
    // Also where that format has no checksum that we know.
    EXPECT_NE(refusal("{\"format\": 99, \"other\": 1}").find(message), std::string::npos);
}

TEST(Manifest, OfAFormatListsOnlyAssetsThatItHas) {
    const std::string hash(32, 'a');
    for (const auto& [extension, first] : {std::pair{".ply", 1}, {".exr", 2}, {".png", 2}, {".hdr", 4}, {".jpg", 4}})
        for (int format = 1; format <= kCacheFormat; ++format) {
            Manifest m;
            m.scene = "bare";
            m.format = format;
            m.assets = {{asset_file_name(hash, extension), 1, hash}};
            const std::string told = refusal(print_manifest(m));
            if (format >= first)
                EXPECT_EQ(told, "") << extension << format;
            else
                EXPECT_NE(told.find("\"assets\" lists"), std::string::npos) << extension << format;
        }
}

TEST(Manifest, EveryFlippedBitAndEveryTruncationIsFound) {
    const std::string text = print_manifest(sample());
    for (std::size_t i = 0; i < text.size(); ++i) {
        std::string flipped = text;
        flipped[i] = static_cast<char>(flipped[i] ^ (1 << (i % 8)));
        ASSERT_NE(refusal(flipped).find("manifest.json"), std::string::npos) << i;
        ASSERT_NE(refusal(text.substr(0, i)).find("manifest.json"), std::string::npos) << i;
    }
}

TEST(Manifest, WrongTypesAreNamedByTheirKey) {
    const std::vector<std::array<std::string, 3>> cases = {
        {"\"format\": 1", "\"format\": \"1\"", "format"},
        {"\"format\": 1", "\"format\": 0", "format"},
        {"\"format\": 1", "\"format\": -3", "format"},
        {"\"scene\": \"pour\"", "\"scene\": 7", "scene"},
        {"\"complete\": false", "\"complete\": 0", "complete"},
        {"\"simulation_hash\"", "\"simulation\"", "simulation_hash"},
        {"\"time\": ", "\"time\": null, \"t\": ", "frames.time"},
        {"\"time\": ", "\"time\": [], \"t\": ", "frames.time"},
        {"\"size\": 4", "\"size\": -4", "assets.size"},
        {"\"size\": 4", "\"size\": 4.5", "assets.size"},
        {"\"size\": 4", "\"size\": 99999999999999999999999", "assets.size"},
        {"\"size\": 4", "\"size\": 18446744073709551615", "assets.size"},
        {"\"frame\": 2", "\"frame\": 5000000000", "frames.frame"},
        {"\"frame\": 2", "\"frame\": -1", "frames.frame"},
        {"\"hash\": \"", "\"hash\": \"zz", "assets.hash"},
        {"\"files\": [", "\"files\": [[],", "files"},
        {"\"frames\": 3", "\"frames\": 4", "totals"},
    };
    for (const auto& [from, to, key] : cases) {
        const std::string message = refusal(edited(from, to));
        EXPECT_NE(message.find(key), std::string::npos) << to << " gave: " << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << "more than one line";
    }
}

TEST(Manifest, NoNameLeadsOutOfTheCacheFolder) {
    EXPECT_NE(refusal(edited("\"particles.0001.vdb\"", "\"../particles.0001.vdb\"")), "");
    EXPECT_NE(refusal(edited("\"assets/", "\"../assets/")), "");
    EXPECT_NE(refusal(edited("\"surfels.0001.vdb\"", "\"/etc/passwd\"")), "");
    // The film, and the scene that a repair simulates, are named after the scene.
    EXPECT_NE(refusal(edited("\"scene\": \"pour\"", "\"scene\": \"../../pour\"")).find("which is no name"),
              std::string::npos);
}

TEST(Manifest, DuplicatedAndUnorderedFramesAreRefused) {
    Manifest twice = sample();
    twice.frames.insert(twice.frames.begin() + 1, twice.frames[0]);
    EXPECT_NE(refusal(print_manifest(twice)).find("frame 1 follows frame 1"), std::string::npos);
    Manifest swapped = sample();
    std::swap(swapped.frames[0], swapped.frames[1]);
    EXPECT_NE(refusal(print_manifest(swapped)).find("frame 1 follows frame 2"), std::string::npos);
}

TEST(Manifest, GarbageIsRefused) {
    for (const std::string& text :
         {std::string(), std::string("[]"), std::string("7"), std::string("null"), std::string("{}"),
          std::string("{\"format\": 1}"), std::string(1000, '\0'), std::string(100'000, '['), std::string("\xff\xfe{}"),
          std::string("{\"format\": 1e999}")})
        EXPECT_NE(refusal(text).find("'manifest.json' is damaged"), std::string::npos) << text.substr(0, 40);
}

TEST(Manifest, IsNotParsedBeforeItsChecksumMatches) {
    const std::string deep(20'000'000, '[');
    EXPECT_NE(refusal(deep).find("checksum does not match"), std::string::npos);
    EXPECT_NE(refusal(edited("\"frames\": [", "\"frames\": [" + std::string(100'000, '['))).find("nested"),
              std::string::npos);
}

TEST(Manifest, ATextThatIsNotUtf8IsRefusedWhenWritten) {
    Manifest m = sample();
    m.scene_text = "scene: \xff";
    EXPECT_NE(message_of([&] { print_manifest(m); }, kBadInput).find("UTF-8"), std::string::npos);
}

}  // namespace
}  // namespace thixo::test
