// Ids of names as every reader of Cryptomatte expects them.
#include "render/cryptomatte.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

namespace thixo::render {
namespace {

TEST(Cryptomatte, HashesAreThoseOfMurmur3) {
    // Published check values, seed 0; the lengths leave tails of 0, 1 and 3 bytes.
    EXPECT_EQ(murmur3(""), 0u);
    EXPECT_EQ(murmur3("hello"), 0x248bfa47u);
    EXPECT_EQ(murmur3("hello, world"), 0x149bbb7fu);
    EXPECT_EQ(murmur3("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
}

TEST(Cryptomatte, EveryIdIsAnOrdinaryFloat) {
    // The empty name hashes to 0, whose float would be no normal number; so does one name in 128 at random.
    for (int k = 0; k < 4096; ++k) {
        const float id = std::bit_cast<float>(cryptomatte_id(k == 0 ? "" : std::to_string(k)));
        EXPECT_TRUE(std::isnormal(id)) << k;
    }
}

TEST(Cryptomatte, TheManifestLeadsFromNamesToIds) {
    std::map<std::string, std::string> attributes;
    describe_cryptomatte("CryptoObject", {"ball", "the \"queen\""}, attributes);
    ASSERT_EQ(attributes.size(), 4u);
    std::string manifest;
    for (const auto& [key, value] : attributes) {
        EXPECT_EQ(key.substr(0, 12), "cryptomatte/");
        EXPECT_EQ(key.find('/', 12), 19u) << "seven digits";
        if (key.ends_with("/manifest")) manifest = value;
        if (key.ends_with("/name")) EXPECT_EQ(value, "CryptoObject");
    }
    char id[9];
    std::snprintf(id, sizeof id, "%08x", cryptomatte_id("ball"));
    EXPECT_NE(manifest.find(std::string("\"ball\":\"") + id + "\""), std::string::npos) << manifest;
    EXPECT_NE(manifest.find("the \\\"queen\\\""), std::string::npos) << manifest;
}

TEST(Cryptomatte, RanksGoByTheShareOfSamples) {
    std::vector<Coverage> coverage;
    for (const std::uint32_t id : {5u, 9u, 9u, 3u}) count(coverage, id);
    sort_by_rank(coverage);
    ASSERT_EQ(coverage.size(), 3u);
    EXPECT_EQ(coverage[0].id, 9u);
    EXPECT_EQ(coverage[0].samples, 2);
    EXPECT_EQ(coverage[1].id, 3u);
}

}  // namespace
}  // namespace thixo::render
