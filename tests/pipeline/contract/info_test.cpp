#include "pipeline/contract/info.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "pipeline/contract/image.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

using nlohmann::ordered_json;

std::vector<std::string> keys(const ordered_json& j) {
    std::vector<std::string> list;
    for (const auto& item : j.items()) list.push_back(item.key());
    return list;
}

const std::vector<std::string> kFrameKeys = {"frame",   "time", "particles", "surfels", "bodies", "air",
                                             "virtual", "mass", "momentum",  "energy",  "volume", "sha"};

TEST(Info, OfACacheHasExactlyThePromisedKeys) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), 2);
    const auto j = ordered_json::parse(describe(out.path(), true));
    EXPECT_EQ(keys(j), (std::vector<std::string>{"scene", "format", "complete", "frames", "shortfalls"}));
    EXPECT_EQ(j["scene"], "pour");
    EXPECT_EQ(j["format"], 1);
    EXPECT_EQ(j["complete"], true);
    ASSERT_EQ(j["frames"].size(), 2u);
    const auto& f = j["frames"][1];
    EXPECT_EQ(keys(f), kFrameKeys);
    EXPECT_EQ(f["frame"], 2);
    EXPECT_EQ(f["time"], 2 / 24.0);
    EXPECT_EQ(f["particles"], 300);
    EXPECT_EQ(f["surfels"], 200);
    EXPECT_EQ(f["bodies"], 2);
    EXPECT_EQ(f["air"], 7);
    EXPECT_EQ(f["virtual"], 11);
    EXPECT_EQ(f["mass"], 1.0 / 3);
    EXPECT_EQ(f["momentum"], (std::vector<double>{0, 0.25, -1e-9}));
    EXPECT_EQ(f["energy"], 1.5);
    EXPECT_EQ(f["volume"], 4e-4);
    EXPECT_NE(f["sha"], j["frames"][0]["sha"]);
}

TEST(Info, ShaIsTheSameForEqualFramesAndAnotherForOthers) {
    const TemporaryFolder a, b;
    write_sample_cache(a.path(), 1);
    CacheWriter writer = CacheWriter::create(b.path(), sample_identity());
    Frame frame = sample_frame(1);
    frame.obstacles[0].asset = writer.add_asset("ply\nthe mesh of a glass\n");
    writer.write_frame(frame);
    const auto sha = [](const fs::path& path) {
        return ordered_json::parse(describe(path, true))["frames"][0]["sha"].get<std::string>();
    };
    EXPECT_EQ(sha(a.path()), sha(b.path()));
    auto& v = std::get<std::vector<Vec3f>>(frame.particles.attributes[2].data);
    v[7].x() = std::nextafter(v[7].x(), 9.0f);
    writer.write_frame(frame);
    EXPECT_NE(sha(a.path()), sha(b.path()));
}

TEST(Info, OfAFrameStatesEveryAttribute) {
    const TemporaryFolder out;
    CacheWriter writer = CacheWriter::create(out.path(), sample_identity());
    Frame frame = sample_frame(1, 0, 5);
    frame.particles.count = 2;
    frame.particles.attributes.clear();
    frame.particles.add("P", std::vector<Vec3f>{{0, 1, 2}, {1, 3, -2}});
    frame.particles.add("temperature", std::vector<float>{10, 40});
    frame.particles.add("id", std::vector<std::int64_t>{4, 5});
    writer.write_frame(frame);
    for (const char* file : {"cache/particles.0001.vdb", "cache/frame.0001.json"}) {
        const auto j = ordered_json::parse(describe(out / file, true));
        EXPECT_EQ(j["frame"], 1);
        EXPECT_EQ(j["particles"], 2);
        const auto& p = j["attributes"]["P"];
        EXPECT_EQ(p["type"], "vec3f");
        EXPECT_EQ(p["min"], (std::vector<double>{0, 1, -2}));
        EXPECT_EQ(p["mean"], (std::vector<double>{0.5, 2, 0}));
        EXPECT_EQ(p["max"], (std::vector<double>{1, 3, 2}));
        const auto& t = j["attributes"]["temperature"];
        EXPECT_EQ(keys(t), (std::vector<std::string>{"type", "min", "mean", "max"}));
        EXPECT_EQ(t["type"], "float");
        EXPECT_EQ(t["mean"], 25);
        EXPECT_EQ(j["attributes"]["id"]["type"], "int64");
        EXPECT_EQ(j["attributes"]["id"]["max"], 5);
    }
    EXPECT_TRUE(ordered_json::parse(describe(out / "cache/frame.0001.json", true))["surfel_attributes"].contains("v"));
    EXPECT_TRUE(ordered_json::parse(describe(out / "cache/surfels.0001.vdb", true))["attributes"].contains("body"));
    EXPECT_NE(describe(out / "cache/particles.0001.vdb", false).find("temperature    float  min 10  mean 25  max 40"),
              std::string::npos);
    EXPECT_NE(describe(out.path(), false).find("cache of scene 'pour', format 1, 1 frames, not complete"),
              std::string::npos);
}

TEST(Info, APointFileThatStandsAloneIsRead) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), 1);
    fs::copy_file(out / "cache/surfels.0001.vdb", out / "alone.vdb");
    EXPECT_EQ(ordered_json::parse(describe(out / "alone.vdb", true))["points"], 200);
}

TEST(Info, OfAPictureStatesChannelsAndHeader) {
    const TemporaryFolder folder;
    Image image(2, 1);
    image.add("R") = {1, 3};
    image.attributes["thixo_frame"] = "4";
    write_exr(folder / "f.exr", image);
    const auto j = ordered_json::parse(describe(folder / "f.exr", true));
    EXPECT_EQ(j["width"], 2);
    EXPECT_EQ(j["height"], 1);
    EXPECT_EQ(j["attributes"]["R"]["mean"], 2);
    EXPECT_EQ(j["attributes"]["R"]["type"], "half");
    EXPECT_EQ(j["header"]["thixo_frame"], "4");
}

TEST(Info, OfAnythingElseSaysSo) {
    const TemporaryFolder folder;
    write_whole(folder / "x.txt", "x");
    EXPECT_FALSE(describes(folder / "x.txt"));
    EXPECT_NE(message_of([&] { describe(folder / "x.txt", true); }, kBadCache).find("x.txt"), std::string::npos);
    EXPECT_NE(message_of([&] { describe(folder / "none.vdb", true); }, kBadCache).find("none.vdb' is missing"),
              std::string::npos);
}

}  // namespace
}  // namespace thixo::test
