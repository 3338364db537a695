// What a run could not do: the list in frames, over all frames, and the energy that came from nowhere.
#include "pipeline/contract/shortfall.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "pipeline/contract/cache_shortfalls.h"
#include "pipeline/contract/info.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

const std::vector<Shortfall> kSome = {{Lack::blocked, "tap", 30, 40, 0}, {Lack::cut_off, "density", 2, 5, 0.01}};

/// A cache of frames with these totals, of this scene.
void write_cache(const fs::path& out, const std::string& scene, const std::vector<FrameTotals>& totals,
                 const std::vector<Shortfall>& shortfalls = {}) {
    CacheWriter writer = CacheWriter::create(out, {"test", scene, "0123456789abcdef"});
    for (std::size_t k = 0; k < totals.size(); ++k) {
        Frame frame = sample_frame(static_cast<int>(k) + 1);
        frame.obstacles.clear();
        frame.totals = totals[k];
        frame.shortfalls = shortfalls;
        writer.write_frame(frame);
    }
}

std::vector<Shortfall> found(const std::string& scene, const std::vector<FrameTotals>& totals,
                             const std::vector<Shortfall>& shortfalls = {}) {
    const TemporaryFolder out;
    write_cache(out.path(), scene, totals, shortfalls);
    return shortfalls_of(CacheReader(out.path()));
}

/// Water at rest that comes to move. A kilogramme, spacing 0.05 m: weight times a spacing is 0.49 J.
std::vector<FrameTotals> gaining(double kinetic) {
    FrameTotals still, moving;
    still.mass = moving.mass = 1;
    still.particle_volume = moving.particle_volume = 1e-3;
    moving.kinetic_energy = kinetic;
    return {still, moving};
}

const std::string kDrop = "scene: {name: test}\nmaterials: {water: {}}\n";

TEST(Shortfalls, OfAFrameComeBackAsTheyWere) {
    Frame frame = sample_frame(1);
    frame.shortfalls = kSome;
    EXPECT_EQ(parse_frame_facts(print_frame_facts(frame), "frame.0001.json").shortfalls, kSome);
}

TEST(Shortfalls, AFrameWithoutAnyIsAsItWasBeforeThereWereAny) {
    EXPECT_EQ(print_frame_facts(sample_frame(1)).find("shortfalls"), std::string::npos);
}

TEST(Shortfalls, OfAnUnknownKindAreRefused) {
    Frame frame = sample_frame(1);
    frame.shortfalls = kSome;
    std::string text = print_frame_facts(frame);
    text.replace(text.find("\"blocked\""), 9, "\"bllcked\"");
    message_of([&] { parse_frame_facts(text, "frame.0001.json"); }, kBadCache);
}

TEST(Shortfalls, WhatHappensInFramesAddsUpAndWhatAStateShowsIsItsWorst) {
    std::vector<Shortfall> list = kSome;
    merge_shortfalls({{Lack::cut_off, "density", 1, 7, 0.002}, {Lack::blocked, "tap", 50, 80, 0}}, list);
    merge_shortfalls({{Lack::blocked, "other", 1, 2, 0}}, list);
    EXPECT_EQ(list, (std::vector<Shortfall>{{Lack::blocked, "other", 1, 2, 0},
                                            {Lack::blocked, "tap", 50, 80, 0},
                                            {Lack::cut_off, "density", 3, 12, 0.01}}));
}

TEST(Shortfalls, OfACacheAreThoseOfItsFrames) {
    const std::vector<Shortfall> two = {{Lack::blocked, "tap", 30, 40, 0}, {Lack::cut_off, "density", 4, 10, 0.01}};
    EXPECT_EQ(found(kDrop, {{}, {}}, kSome), two);
}

TEST(Shortfalls, StandInInfoForPeopleAndPrograms) {
    const TemporaryFolder out;
    write_cache(out.path(), kDrop, {{}}, kSome);
    const auto json = nlohmann::ordered_json::parse(describe(out.path(), true));
    ASSERT_EQ(json["shortfalls"].size(), 2u);
    EXPECT_EQ(json["shortfalls"][0]["kind"], "blocked");
    EXPECT_EQ(json["shortfalls"][0]["name"], "tap");
    EXPECT_EQ(json["shortfalls"][0]["count"], 30);
    EXPECT_EQ(json["shortfalls"][0]["of"], 40);
    EXPECT_NE(describe(out.path(), false).find("emitter 'tap' is blocked: 75 %"), std::string::npos);
}

TEST(Shortfalls, EveryKindHasAWordAndASentence) {
    for (std::size_t k = 0; k < kLackWords.size(); ++k)
        EXPECT_GT(shortfall_text({static_cast<Lack>(k), "x", 1, 2, 3}).size(), 40u) << kLackWords[k];
}

TEST(EnergyFromNowhere, IsToldWhereMotionGainsMoreThanThereWas) {
    const std::vector<Shortfall> list = found(kDrop, gaining(50));
    ASSERT_EQ(list.size(), 1u);
    EXPECT_EQ(list[0].lack, Lack::energy);
    EXPECT_EQ(list[0].worst, 50);
    EXPECT_EQ(list[0].count, 1);
}

TEST(EnergyFromNowhere, IsNotWhatFallingGives) {
    std::vector<FrameTotals> falling = gaining(50);
    falling[1].potential_energy = -50;
    EXPECT_TRUE(found(kDrop, falling).empty());
}

TEST(EnergyFromNowhere, IsNotWhatSettlingByASpacingCosts) { EXPECT_TRUE(found(kDrop, gaining(0.49)).empty()); }

TEST(EnergyFromNowhere, IsNotWhatTensionReleases) {
    // 6 gamma V/d = 6 x 1 N/m x 1e-3 m^3 / 0.05 m = 0.12 J beside 0.49 J and a tenth of the motion's 0.6 J.
    EXPECT_FALSE(found(kDrop, gaining(0.6)).empty());
    EXPECT_TRUE(found("scene: {name: test}\nmaterials: {water: {surface_tension: 1}}\n", gaining(0.6)).empty());
}

TEST(EnergyFromNowhere, IsNotTheRoundingOfMatterAtRest) {
    // Of 1 kg, 0.1 m wide, in 24 frames a second: 3e-12 J.
    const std::string floating = "scene: {name: test}\nmaterials: {water: {}}\nworld: {gravity: [0, 0, 0]}\n";
    EXPECT_TRUE(found(floating, gaining(1e-12)).empty());
    EXPECT_FALSE(found(floating, gaining(1e-10)).empty());
}

TEST(EnergyFromNowhere, IsNotLookedForWhereSomethingDrivesTheScene) {
    const std::string wall = "world: {boundaries: {w: {shape: {sphere: {}}, motion: [{time: 0}, {time: 1}]}}}\n",
                      tap = "emitters: {tap: {material: water}}\n",
                      wind = "world: {periodic: [{axis: z, from: 0, to: 9}]}\nsurface: {enabled: false}\n";
    for (const std::string& driven : {wall, tap, wind}) EXPECT_TRUE(found(kDrop + driven, gaining(50)).empty());
}

}  // namespace
}  // namespace thixo::test
