// Checks of caches: every attribute by id, and every fact of a frame.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "pipeline/check/check.h"
#include "pipeline/check/compare_frames.h"
#include "pipeline/check/compare_manifests.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo {
namespace {

using test::sample_frame;
using test::TemporaryFolder;
namespace fs = std::filesystem;

std::string problems_of(const FrameReport& report) {
    std::string text;
    for (const std::string& p : report.problems) text += p + "\n";
    return text;
}

/// The problems that compare_frames reports after `change` was made to a copy of a sample frame.
template <class F>
std::string after(F&& change) {
    Frame a = sample_frame(2);
    change(a);
    return problems_of(compare_frames("frame 2", a, sample_frame(2)));
}

template <class T>
std::vector<T>& values(PointSet& points, const char* name) {
    for (Attribute& a : points.attributes)
        if (a.name == name) return std::get<std::vector<T>>(a.data);
    throw std::runtime_error(name);
}

void reverse_points(PointSet& points) {
    for (Attribute& a : points.attributes) std::visit([](auto& v) { std::reverse(v.begin(), v.end()); }, a.data);
}

bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

TEST(FrameComparison, PairsPointsByIdNotByPlace) {
    EXPECT_EQ(after([](Frame& f) { reverse_points(f.particles); }), "");
}

TEST(FrameComparison, NamesTheAttributeAndThePointThatDiffer) {
    Frame a = sample_frame(2);
    auto& v = values<Vec3f>(a.particles, "v");
    v[17].y() = std::nextafter(v[17].y(), 9.0f);
    const FrameReport report = compare_frames("frame 2", a, sample_frame(2));
    ASSERT_EQ(report.attributes.size(), 1u);
    EXPECT_EQ(report.attributes[0].name, "particles.v");
    EXPECT_EQ(report.attributes[0].different, 1u);
    EXPECT_EQ(report.attributes[0].worst_id, values<std::int64_t>(a.particles, "id")[17]);
}

TEST(FrameComparison, FailsOnEveryKindOfFact) {
    EXPECT_EQ(after([](Frame&) {}), "");
    EXPECT_TRUE(says(after([](Frame& f) { f.time = std::nextafter(f.time, 9.0); }), "time"));
    EXPECT_TRUE(says(after([](Frame& f) { f.spacing *= 2; }), "spacing"));
    EXPECT_TRUE(says(after([](Frame& f) { f.bodies[1].material = "oil"; }), "bodies"));
    EXPECT_TRUE(says(after([](Frame& f) { f.bodies.pop_back(); }), "bodies"));
    EXPECT_TRUE(says(after([](Frame& f) { f.obstacles[0].transform[7] = 1e-300; }), "obstacles: 'glass' differs"));
    EXPECT_TRUE(says(after([](Frame& f) { f.totals.momentum[2] *= 1.5; }), "momentum.z"));
    EXPECT_TRUE(says(after([](Frame& f) { ++f.totals.virtual_particles; }), "virtual"));
    EXPECT_TRUE(
        says(after([](Frame& f) { f.surfels = test::sample_points(199, 1002); }), "199 surfels, the reference 200"));
    EXPECT_TRUE(says(after([](Frame& f) { f.particles.attributes.pop_back(); }), "particles.body is missing"));
    EXPECT_TRUE(says(after([](Frame& f) { f.particles.add("extra", std::vector<float>(300)); }),
                     "particles.extra is not in the reference"));
    EXPECT_TRUE(says(after([](Frame& f) { f.particles.attributes[4].data = std::vector<float>(300); }),
                     "particles.body has another type"));
    EXPECT_TRUE(says(after([](Frame& f) { values<std::int64_t>(f.particles, "id")[5] += 1000; }), "other ids"));
}

TrimNode sheet(int number) { return {TrimNode::Op::sheet, number, {}}; }

/// Two sheets, a body bounded by both.
Frame creased_frame() {
    Frame frame = sample_frame(2);
    frame.bodies[0].trim = TrimNode{TrimNode::Op::all, 0, {sheet(0), sheet(1)}};
    return frame;
}

TEST(FrameComparison, FailsOnOtherTrimTrees) {
    const Frame reference = creased_frame();
    const auto other_trim = [&](std::optional<TrimNode> trim) {
        Frame frame = reference;
        frame.bodies[0].trim = std::move(trim);
        return problems_of(compare_frames("frame 2", frame, reference));
    };
    EXPECT_EQ(other_trim(reference.bodies[0].trim), "");
    const std::string differs = "bodies: 'pour' differs in trim tree\n";
    EXPECT_EQ(other_trim(std::nullopt), differs);
    EXPECT_EQ(other_trim(TrimNode{TrimNode::Op::any, 0, {sheet(0), sheet(1)}}), differs);
    EXPECT_EQ(other_trim(TrimNode{TrimNode::Op::all, 0, {sheet(0), sheet(2)}}), differs);
    EXPECT_EQ(other_trim(TrimNode{TrimNode::Op::all, 0, {sheet(0)}}), differs);
    EXPECT_EQ(other_trim(TrimNode{TrimNode::Op::all, 0, {sheet(0), {TrimNode::Op::any, 0, {sheet(1)}}}}), differs);
}

using Json = nlohmann::ordered_json;

/// Another value of the same type.
Json another(const Json& value) {
    if (value.is_string()) return value.get<std::string>() + "x";
    if (value.is_number_integer()) return value.get<std::int64_t>() + 1;
    if (value.is_number()) return value.get<double>() + 1;
    throw std::runtime_error("a value of no type that frame files hold: " + value.dump());
}

// The file is taken as it is printed, so that a fact that is added to it is tried as well.
TEST(FrameComparison, FailsOnAChangeOfAnyValueInAFrameFile) {
    const std::string text = print_frame_facts(creased_frame());
    const Frame reference = parse_frame_facts(text, "reference");
    const Json values = Json::parse(text).flatten();
    ASSERT_GT(values.size(), 40u);
    for (const auto& [place, value] : values.items()) {
        if (place == "/particles" || place == "/surfels") continue;  // counts, compared with the points themselves
        Json changed = values;
        changed[place] = another(value);
        const Frame frame = parse_frame_facts(changed.unflatten().dump(), "changed");
        EXPECT_NE(problems_of(compare_frames("frame 2", frame, reference)), "") << place;
    }
}

TEST(FrameComparison, FailsOnNaNInBoth) {
    Frame a = sample_frame(2);
    values<float>(a.surfels, "temperature")[3] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(says(problems_of(compare_frames("frame 2", a, a)), "surfels.temperature: 1 points are not finite"));
}

class CacheCheck : public ::testing::Test {
  protected:
    void SetUp() override {
        test::write_sample_cache(folder_ / "a", 3);
        test::write_sample_cache(folder_ / "b", 3);
        args_.path = (folder_ / "a").string();
        args_.against = (folder_ / "b" / "cache").string();  // an output folder against a cache folder
    }
    TemporaryFolder folder_;
    CheckArgs args_;
};

TEST_F(CacheCheck, PassesEqualCaches) {
    const CheckReport report = check(args_);
    EXPECT_EQ(report.kind, "cache");
    EXPECT_EQ(report.frames.size(), 3u);
    EXPECT_EQ(report.notes.size(), 0u);
    EXPECT_EQ(exit_code_of(report), kDone);
}

TEST_F(CacheCheck, FailsOnMissingAndExtraFrames) {
    test::write_sample_cache(folder_ / "short", 2);
    args_.against = (folder_ / "short").string();
    EXPECT_EQ(exit_code_of(check(args_)), kDifferent);
    std::swap(args_.path, args_.against);
    const CheckReport report = check(args_);
    EXPECT_EQ(exit_code_of(report), kDifferent);
    EXPECT_EQ(problems_of(report.frames.back()), "is missing\n");
    args_.frames = "1-2";
    EXPECT_EQ(exit_code_of(check(args_)), kDone);
}

TEST_F(CacheCheck, NotesOtherScenesAndAnUnfinishedSimulation) {
    CacheIdentity identity = test::sample_identity();
    identity.scene = "rain";
    identity.scene_text += "seed: 2\n";
    identity.simulation_hash = "another";
    CacheWriter writer = CacheWriter::create(folder_ / "c", identity);
    for (int n = 1; n <= 3; ++n) {
        Frame frame = sample_frame(n);
        frame.obstacles[0].asset = writer.add_asset("ply\nthe mesh of a glass\n");
        writer.write_frame(frame);
    }
    args_.against = (folder_ / "c").string();
    const CheckReport report = check(args_);
    EXPECT_EQ(exit_code_of(report), kDone);
    EXPECT_EQ(report.notes.size(), 4u);
    const std::string text = print_text(report);
    EXPECT_TRUE(says(text, "note, not compared: the scene is 'pour', the reference's 'rain'\n"));
    EXPECT_TRUE(says(text, "the two were simulated with different settings"));
    EXPECT_TRUE(says(text, "the resolved scenes differ"));
    EXPECT_TRUE(says(text, "the reference's simulation has not reached its last frame"));
    EXPECT_EQ(nlohmann::json::parse(print_json(report))["notes"], report.notes);
}

TEST(ManifestComparison, ComparesTheTimesThatItLists) {
    ManifestFrame a, b;
    EXPECT_TRUE(compare_entries(a, b).empty());
    a.time = 0.5;
    EXPECT_EQ(compare_entries(a, b).size(), 1u);
}

TEST_F(CacheCheck, CallsATruncatedFileDamaged) {
    const fs::path file = folder_ / "a" / "cache" / "particles.0002.vdb";
    fs::resize_file(file, fs::file_size(file) - 1);
    const CheckReport report = check(args_);
    EXPECT_EQ(exit_code_of(report), kBadCache);
    EXPECT_TRUE(report.frames[1].damaged);
    EXPECT_TRUE(report.frames[0].same());
}

TEST_F(CacheCheck, UpdateMakesTheCachesEqualAndLeavesNoStaleFile) {
    fs::remove_all(folder_ / "a");
    test::write_sample_cache(folder_ / "a", 2);
    args_.update = true;
    const CheckReport report = check(args_);
    EXPECT_EQ(report.update.removed.size(), 3u);  // particles, surfels and facts of frame 3
    EXPECT_EQ(test::contents(folder_ / "a" / "cache"), test::contents(folder_ / "b" / "cache"));
}

TEST_F(CacheCheck, UpdateMakesAReferenceThatWasNotThere) {
    args_.update = true;
    args_.against = (folder_ / "c").string();
    check(args_);
    EXPECT_EQ(test::contents(folder_ / "a"), test::contents(folder_ / "c"));
}

TEST_F(CacheCheck, RefusesToCompareACacheWithPictures) {
    make_folder(folder_ / "frames");
    write_whole(folder_ / "frames" / "beauty.0001.exr", "");
    args_.against = (folder_ / "frames").string();
    EXPECT_NE(test::message_of([&] { check(args_); }, kBadInput), "");
}

}  // namespace
}  // namespace thixo
