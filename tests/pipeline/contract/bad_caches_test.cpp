// Damaged caches: each is named in one line, as a CacheError, before it is parsed, and soon.
#include <gtest/gtest.h>

#include <chrono>

#include "pipeline/contract/info.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

/// Reads everything a cache holds.
void read_all(const fs::path& path) {
    const CacheReader reader(path);
    for (const int n : reader.frames()) {
        const Frame frame = reader.load_frame(n);
        for (const FrameObstacle& o : frame.obstacles) reader.load_asset(o.asset);
    }
}

class BadCaches : public ::testing::Test {
  protected:
    void SetUp() override {
        write_sample_cache(out_.path(), 2);
        for (const auto& [name, bytes] : contents(out_.path()))
            if (name.find("0001") == std::string::npos) files_.push_back(name);  // one of every kind
        ASSERT_EQ(files_.size(), 5u);
    }
    /// Expects that reading names the file in one line, within ten seconds (it takes milliseconds; OpenVDB alone took
    /// minutes over a damaged header).
    void expect_named(const std::string& name, const std::string& what) {
        const auto start = std::chrono::steady_clock::now();
        const std::string message = message_of([&] { read_all(out_.path()); }, kBadCache);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        ASSERT_NE(message.find(name), std::string::npos) << what << " of " << name << " gave: " << message;
        ASSERT_EQ(message.find('\n'), std::string::npos) << message;
        ASSERT_LT(seconds, 10) << what << " of " << name;
    }
    void put(const std::string& name, const std::string& bytes) const {
        // Not by write_whole: this is damage, and it need not be flushed to the disk.
        std::FILE* f = std::fopen((out_ / name).c_str(), "wb");
        ASSERT_NE(f, nullptr);
        std::fwrite(bytes.data(), 1, bytes.size(), f);
        std::fclose(f);
    }
    TemporaryFolder out_;
    std::vector<std::string> files_;
};

TEST_F(BadCaches, AreFineWithoutDamage) {
    EXPECT_EQ(message_of([&] { read_all(out_.path()); }, kDone), "");
}

TEST_F(BadCaches, TruncatedFilesAreNamed) {
    for (const std::string& name : files_) {
        const std::string bytes = read_whole(out_ / name);
        for (int k = 0; k < 25; ++k) {
            put(name, bytes.substr(0, bytes.size() * static_cast<std::size_t>(k) / 25));
            expect_named(name, "truncation " + std::to_string(k));
        }
        put(name, bytes.substr(0, bytes.size() - 1));
        expect_named(name, "the last byte cut");
        put(name, bytes);
    }
}

TEST_F(BadCaches, FlippedBitsAreNamed) {
    for (const std::string& name : files_) {
        const std::string bytes = read_whole(out_ / name);
        for (std::uint64_t k = 0; k < 60; ++k) {
            std::string flipped = bytes;
            const std::size_t at = k < 30 ? random_bits(1, k, 0, 0) % std::min<std::size_t>(bytes.size(), 200)
                                          : random_bits(1, k, 0, 0) % bytes.size();
            flipped[at] = static_cast<char>(flipped[at] ^ (1 << random_bits(1, k, 0, 1) % 8));
            put(name, flipped);
            expect_named(name, "bit at " + std::to_string(at));
        }
        put(name, bytes);
    }
}

TEST_F(BadCaches, GrownAndSwappedFilesAreNamed) {
    for (const std::string& name : files_) {
        const std::string bytes = read_whole(out_ / name);
        put(name, bytes + "x");
        expect_named(name, "a byte more");
        put(name, std::string(bytes.size(), '\0'));
        expect_named(name, "zeros");
        put(name, bytes);
    }
    fs::rename(out_ / "cache/particles.0002.vdb", out_ / "cache/x");
    fs::rename(out_ / "cache/particles.0001.vdb", out_ / "cache/particles.0002.vdb");
    fs::rename(out_ / "cache/x", out_ / "cache/particles.0001.vdb");
    expect_named("particles.0001.vdb", "two files swapped");
}

TEST_F(BadCaches, MissingFilesAreNamed) {
    for (const std::string& name : files_) {
        if (name.ends_with("manifest.json")) continue;
        const std::string bytes = read_whole(out_ / name);
        fs::remove(out_ / name);
        expect_named(name + "' is missing", "absence");
        fs::create_directory(out_ / name);
        expect_named(name, "a folder in its place");
        fs::remove(out_ / name);
        put(name, bytes);
    }
    fs::remove(out_ / "cache/manifest.json");
    expect_named("it has no manifest.json", "absence");
    fs::remove_all(out_ / "cache");
    expect_named(out_.path().string(), "an empty folder");
    EXPECT_NE(message_of([&] { CacheReader reader("/no/such/folder"); }, kBadCache).find("/no/such/folder"),
              std::string::npos);
}

TEST_F(BadCaches, AFrameThatIsNotThereIsNamed) {
    const CacheReader reader(out_.path());
    EXPECT_NE(message_of([&] { reader.load_frame(3); }, kBadCache).find("has no frame 3"), std::string::npos);
}

TEST_F(BadCaches, AreNamedByInfoToo) {
    put("cache/frame.0002.json", "{}");
    for (const bool json : {true, false})
        EXPECT_NE(message_of([&] { describe(out_.path(), json); }, kBadCache).find("frame.0002.json"),
                  std::string::npos);
    EXPECT_NE(message_of([&] { describe(out_ / "cache/frame.0002.json", true); }, kBadCache).find("frame.0002.json"),
              std::string::npos);
}

// Checksums stop accidents; a file made on purpose must still not crash the parser of frame facts.
TEST(FrameFacts, AnyTextParsesOrIsRefused) {
    const std::string text = print_frame_facts(sample_frame(1));
    int refused = 0;
    for (std::uint64_t k = 0; k < 20'000; ++k) {
        std::string changed = text;
        for (std::uint64_t edit = 0; edit < 1 + k % 4; ++edit) {
            const std::size_t at = random_bits(7, k, edit, 0) % changed.size();
            const char* pieces[] = {"null", "[", "}",    "-1",       "1e999", "99999999999999999999",
                                    "\"",   "",  "true", "{\"a\":1}"};
            changed.replace(at, random_bits(7, k, edit, 1) % 6, pieces[random_bits(7, k, edit, 2) % std::size(pieces)]);
        }
        try {
            parse_frame_facts(changed, "frame.json");
        } catch (const CacheError& e) {
            ASSERT_NE(std::string(e.what()).find("frame.json"), std::string::npos);
            ++refused;
        }
    }
    EXPECT_GT(refused, 10'000);
}

TEST(FrameFacts, WrongTypesAreNamedByTheirKey) {
    const std::string text = print_frame_facts(sample_frame(1));
    const std::vector<std::array<std::string, 3>> cases = {
        {"\"frame\": 1", "\"frame\": 1.5", "frame"},
        {"\"time\":", "\"t\":", "time"},
        {"\"mass\": ", "\"mass\": \"\", \"m\": ", "totals.mass"},
        {"\"air\": 7", "\"air\": -7", "totals.air"},
        {"\"id\": 3", "\"id\": 3000000000", "bodies.id"},
        {"\"transform\": [", "\"transform\": [0, ", "obstacles.transform"},
        {"\"bodies\": [", "\"bodies\": [7, ", "bodies"},
        {"\"look\": \"glass\"", "\"look\": 1", "obstacles.look"},
    };
    for (const auto& [from, to, key] : cases) {
        std::string changed = text;
        const std::size_t at = changed.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        changed.replace(at, from.size(), to);
        const std::string message = message_of([&] { parse_frame_facts(changed, "frame.json"); }, kBadCache);
        EXPECT_NE(message.find("\"" + key + "\""), std::string::npos) << to << " gave: " << message;
    }
}

}  // namespace
}  // namespace thixo::test
