#include "pipeline/contract/cache.h"

#include <gtest/gtest.h>

#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

constexpr int kLast = 2;
constexpr int kWrites = 1 + 1 + 4 * kLast + 1;  // manifest, asset, three files and the manifest a frame, the end

/// Goes on from the frames that are whole, as a simulation does from its checkpoint.
void continue_sample_cache(const fs::path& out, int last) {
    const bool there = CacheReader::exists(out);
    const std::vector<int> frames = there ? CacheReader(out).frames() : std::vector<int>();
    const int kept = frames.empty() ? 0 : frames.back();
    CacheWriter writer =
        there ? CacheWriter::resume(out, sample_identity(), kept) : CacheWriter::create(out, sample_identity());
    const std::string glass = writer.add_asset("ply\nthe mesh of a glass\n");
    for (int n = kept + 1; n <= last; ++n) {
        Frame frame = sample_frame(n);
        frame.obstacles[0].asset = glass;
        writer.write_frame(frame);
    }
    writer.finish();
}

TEST(FrameFacts, FrontsOfCracksComeBackAndAreAbsentWhereThereAreNone) {
    Frame frame = sample_frame(1);
    EXPECT_EQ(print_frame_facts(frame).find("fronts"), std::string::npos);
    frame.fronts = {{.closed = true, .nodes = {{0.1, -2, 3e-7}, {4, 5, 6}}}, {.closed = false, .nodes = {{1, 2, 3}}}};
    const std::string text = print_frame_facts(frame);
    const Frame back = parse_frame_facts(text, "frame.0001.json");
    ASSERT_EQ(back.fronts.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_EQ(back.fronts[k].closed, frame.fronts[k].closed);
        EXPECT_EQ(back.fronts[k].nodes, frame.fronts[k].nodes);
    }
    std::string damaged = text;
    damaged.replace(damaged.find("\"closed\""), 8, "\"ajar\"  ");
    EXPECT_THROW(parse_frame_facts(damaged, "frame.0001.json"), CacheError);
    frame.fronts[0].nodes[0][1] = std::nan("");
    EXPECT_THROW(print_frame_facts(frame), DivergedError);
}

TEST(Cache, FramesComeBackAsTheyWere) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), kLast);
    const CacheReader reader(out.path());
    EXPECT_TRUE(reader.complete());
    EXPECT_EQ(reader.scene_text(), sample_identity().scene_text);
    EXPECT_EQ(reader.frames(), (std::vector<int>{1, 2}));
    for (const int n : reader.frames()) {
        const Frame expected = sample_frame(n), frame = reader.load_frame(n);
        EXPECT_EQ(frame.number, n);
        EXPECT_EQ(frame.time, expected.time);
        EXPECT_EQ(frame.spacing, expected.spacing);
        expect_same_points(frame.particles, expected.particles);
        expect_same_points(frame.surfels, expected.surfels);
        ASSERT_EQ(frame.bodies.size(), 2u);
        EXPECT_EQ(frame.bodies[1].id, 3);
        EXPECT_EQ(frame.bodies[1].parent, 0);
        EXPECT_EQ(frame.bodies[1].name, "drop \"3\"");
        EXPECT_EQ(frame.bodies[1].material, "water");
        ASSERT_EQ(frame.obstacles.size(), 1u);
        EXPECT_EQ(frame.obstacles[0].transform, expected.obstacles[0].transform);
        EXPECT_EQ(frame.obstacles[0].velocity, expected.obstacles[0].velocity);
        EXPECT_EQ(reader.load_asset(frame.obstacles[0].asset), "ply\nthe mesh of a glass\n");
        EXPECT_EQ(frame.totals.mass, expected.totals.mass);
        EXPECT_EQ(frame.totals.momentum, expected.totals.momentum);
        EXPECT_EQ(frame.totals.surface_volume, expected.totals.surface_volume);
        EXPECT_EQ(frame.totals.air, 7);
        EXPECT_EQ(frame.totals.virtual_particles, 11);
    }
}

TEST(Cache, OpensByItsFolderItsOutFolderAndItsManifest) {
    const TemporaryFolder out;
    EXPECT_FALSE(CacheReader::exists(out.path()));
    EXPECT_NE(
        message_of([&] { CacheReader reader(out.path()); }, kBadCache).find("no cache in '" + out.path().string()),
        std::string::npos);
    write_sample_cache(out.path(), 1);
    for (const fs::path& path : {out.path(), out / "cache", out / "cache/manifest.json"}) {
        EXPECT_TRUE(CacheReader::exists(path));
        EXPECT_EQ(CacheReader(path).frames().size(), 1u);
    }
}

TEST(Cache, MovedElsewhereItIsTheSame) {
    const TemporaryFolder out;
    write_sample_cache(out / "here", 1);
    fs::rename(out / "here", out / "there");
    expect_same_points(CacheReader(out / "there").load_surfels(1), sample_frame(1).surfels);
}

TEST(Cache, EqualFramesGiveEqualFiles) {
    const TemporaryFolder a, b;
    write_sample_cache(a.path(), kLast);
    write_sample_cache(b.path(), kLast);
    EXPECT_EQ(contents(a.path()), contents(b.path()));
    EXPECT_EQ(contents(a.path()).size(), 1u + 1u + 3u * kLast);
}

TEST(Cache, AnAssetIsStoredOnce) {
    const TemporaryFolder out;
    CacheWriter writer = CacheWriter::create(out.path(), sample_identity());
    const std::string first = writer.add_asset("one"), second = writer.add_asset("two");
    EXPECT_EQ(writer.add_asset("one"), first);
    writer.finish();
    const CacheReader reader(out.path());
    EXPECT_EQ(reader.manifest().assets.size(), 2u);
    EXPECT_EQ(reader.load_asset(second), "two");
    EXPECT_NE(message_of([&] { reader.load_asset(hash_hex("three")); }, kBadCache).find("no asset"), std::string::npos);
}

TEST(Cache, AReaderSeesFramesThatAreMadeMeanwhile) {
    const TemporaryFolder out;
    CacheWriter writer = CacheWriter::create(out.path(), sample_identity());
    CacheReader reader(out.path());
    EXPECT_TRUE(reader.frames().empty());
    EXPECT_FALSE(reader.refresh());
    writer.write_frame(sample_frame(1));
    EXPECT_TRUE(reader.refresh());
    EXPECT_TRUE(reader.has_frame(1));
    EXPECT_FALSE(reader.complete());
    writer.finish();
    EXPECT_TRUE(reader.refresh());
    EXPECT_TRUE(reader.complete());
}

TEST(Cache, ResumingRewritesLaterFramesToTheSameBytes) {
    const TemporaryFolder whole, resumed;
    write_sample_cache(whole.path(), kLast);
    write_sample_cache(resumed.path(), kLast);
    {
        const CacheWriter writer = CacheWriter::resume(resumed.path(), sample_identity(), 1);
        const CacheReader reader(resumed.path());
        EXPECT_EQ(reader.frames(), std::vector<int>{1});
        EXPECT_FALSE(reader.complete());
        EXPECT_FALSE(fs::exists(resumed / "cache/particles.0002.vdb"));
    }
    continue_sample_cache(resumed.path(), kLast);
    EXPECT_EQ(contents(resumed.path()), contents(whole.path()));
}

TEST(Cache, ACompleteCacheThatNeedsNothingIsNotWrittenTo) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), 1);
    const int status = in_child("1:0:enospc", [&] {
        return CacheWriter::resume(out.path(), sample_identity(), 1).manifest().complete ? 0 : 50;
    });
    EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(Cache, NothingIsOverwrittenUnasked) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), 1);
    const auto before = contents(out.path());
    EXPECT_NE(message_of([&] { CacheWriter::create(out.path(), sample_identity()); }, kBadInput).find("--restart"),
              std::string::npos);
    CacheIdentity other = sample_identity();
    other.simulation_hash = "another";
    EXPECT_NE(message_of([&] { CacheWriter::resume(out.path(), other, 1); }, kBadInput).find("--restart"),
              std::string::npos);
    EXPECT_EQ(contents(out.path()), before);
    fs::remove(out / "cache/surfels.0001.vdb");
    EXPECT_NE(message_of([&] { CacheWriter::resume(out.path(), sample_identity(), 1); }, kBadCache)
                  .find("surfels.0001.vdb' is missing or damaged"),
              std::string::npos);
}

TEST(Cache, RestartRemovesTheOldFramesAndNothingElse) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), kLast);
    write_whole(out / "cache/notes.txt", "mine");
    CacheWriter::restart(out.path(), sample_identity());
    const auto files = contents(out.path());
    EXPECT_EQ(files.size(), 2u);
    EXPECT_TRUE(files.contains("cache/manifest.json"));
    EXPECT_TRUE(files.contains("cache/notes.txt"));
}

TEST(Cache, FilesOfOtherProgramsStayWhateverTheCacheDoes) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), kLast);
    const std::map<std::string, std::string> others = {{"cache/assets/logo.png", "a logo"},
                                                       {"cache/particles.backup.vdb", "a backup"},
                                                       {"cache/frame.notes.json", "{}"},
                                                       {"cache/particles.1.vdb", "another tool's"},
                                                       {"cache/.thixo-notes", "mine"}};
    for (const auto& [name, bytes] : others) write_whole(out / name, bytes);
    CacheWriter::resume(out.path(), sample_identity(), 1);
    continue_sample_cache(out.path(), kLast);
    CacheWriter::restart(out.path(), sample_identity());
    for (const auto& [name, bytes] : others) EXPECT_EQ(read_whole(out / name), bytes) << name;
}

TEST(Cache, AFileOfAnotherProgramInTheWayIsRefusedByName) {
    for (const char* name : {"cache/particles.0002.vdb", "cache/frame.0002.json"}) {
        const TemporaryFolder out;
        write_sample_cache(out.path(), 1);
        write_whole(out / name, "not Thixo's");
        const auto before = contents(out.path());
        for (const bool restart : {false, true}) {
            const std::string message = message_of(
                [&] {
                    restart ? CacheWriter::restart(out.path(), sample_identity())
                            : CacheWriter::resume(out.path(), sample_identity(), 1);
                },
                kBadInput);
            EXPECT_NE(message.find(name), std::string::npos) << message;
            EXPECT_EQ(contents(out.path()), before);
        }
    }
}

TEST(Cache, NothingIsReadOrWrittenThroughALink) {
    const TemporaryFolder out, elsewhere;
    write_sample_cache(out.path(), 1);
    fs::rename(out / "cache/assets", elsewhere / "assets");
    write_whole(elsewhere / "assets/mine.png", "mine");
    const auto kept = contents(elsewhere.path());
    fs::create_symlink(elsewhere / "assets", out / "cache/assets");
    const CacheReader reader(out.path());
    EXPECT_NE(message_of([&] { reader.load_asset(reader.manifest().assets[0].hash); }, kBadCache), "");
    EXPECT_NE(message_of([&] { CacheWriter::restart(out.path(), sample_identity()); }, kBadInput).find("is a link"),
              std::string::npos);
    EXPECT_EQ(contents(elsewhere.path()), kept);

    const TemporaryFolder second;
    write_sample_cache(second.path(), 1);
    fs::rename(second / "cache/particles.0001.vdb", elsewhere / "points.vdb");
    fs::create_symlink(elsewhere / "points.vdb", second / "cache/particles.0001.vdb");
    EXPECT_NE(message_of([&] { CacheReader(second.path()).load_particles(1); }, kBadCache).find("is a link"),
              std::string::npos);
}

TEST(Cache, DamagedFramesAndAssetsAreFoundBeforeTheyAreKept) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), 3);
    const std::string asset = "cache/" + CacheReader(out.path()).manifest().assets[0].name;
    EXPECT_EQ(CacheReader(out.path()).last_sound(1), 3);
    EXPECT_TRUE(CacheReader(out.path()).is_whole(1, 3));
    for (const std::string& name : {std::string("cache/surfels.0002.vdb"), asset}) {
        const std::string bytes = read_whole(out / name);
        std::string flipped = bytes;
        flipped[bytes.size() / 2] = static_cast<char>(flipped[bytes.size() / 2] ^ 1);
        write_whole(out / name, flipped);
        EXPECT_EQ(CacheReader(out.path()).last_sound(1), name == asset ? 3 : 1) << name;
        EXPECT_FALSE(CacheReader(out.path()).is_whole(1, 3)) << name;
        EXPECT_EQ(CacheReader(out.path()).is_whole(1, 1), name != asset) << name;
        fs::remove(out / name);
        EXPECT_EQ(CacheReader(out.path()).last_sound(1), name == asset ? 3 : 1) << name;
        if (name != asset) write_whole(out / name, bytes);
    }
    CacheWriter writer = CacheWriter::resume(out.path(), sample_identity(), 3);
    EXPECT_NE(message_of([&] { writer.require_assets(); }, kBadCache), "");
    writer.add_asset("ply\nthe mesh of a glass\n");
    writer.require_assets();
    EXPECT_TRUE(CacheReader(out.path()).is_whole(1, 3));
}

TEST(Cache, AManifestThatIsAFolderIsADamagedCache) {
    const TemporaryFolder out;
    fs::create_directories(out / "cache/manifest.json");
    for (const fs::path& path : {out.path(), out / "cache/manifest.json"})
        EXPECT_NE(message_of([&] { CacheReader reader(path); }, kBadCache).find("manifest.json"), std::string::npos);
}

TEST(Cache, KilledAtAnyWriteItContinuesToTheSameBytes) {
    const TemporaryFolder whole;
    write_sample_cache(whole.path(), kLast);
    const auto expected = contents(whole.path());
    for (int write = 1; write <= kWrites; ++write) {
        const TemporaryFolder out;
        const int status = in_child(std::to_string(write) + ":20:kill", [&] {
            write_sample_cache(out.path(), kLast);
            return 0;
        });
        ASSERT_TRUE(WIFSIGNALED(status)) << write;
        continue_sample_cache(out.path(), kLast);
        ASSERT_EQ(contents(out.path()), expected) << "killed at write " << write;
    }
}

TEST(Cache, AFullDiskAtAnyWriteKeepsTheFramesThatWereThere) {
    for (int write = 1; write <= kWrites; ++write) {
        const TemporaryFolder out;
        const int status = in_child(std::to_string(write) + ":20:enospc", [&] {
            write_sample_cache(out.path(), kLast);
            return 0;
        });
        ASSERT_TRUE(WIFEXITED(status));
        ASSERT_EQ(WEXITSTATUS(status), kNoResource) << write;
        if (write == 1) {
            EXPECT_FALSE(CacheReader::exists(out.path()));
            continue;
        }
        const CacheReader reader(out.path());
        ASSERT_EQ(static_cast<int>(reader.frames().size()), std::max(0, write - 3) / 4) << write;
        for (const int n : reader.frames())
            expect_same_points(reader.load_frame(n).particles, sample_frame(n).particles);
        for (const auto& [name, bytes] : contents(out.path())) EXPECT_FALSE(name.ends_with(".tmp")) << name;
    }
}

TEST(Cache, AFrameThatCannotBeWrittenLeavesNoTrace) {
    const TemporaryFolder out;
    CacheWriter writer = CacheWriter::create(out.path(), sample_identity());
    writer.write_frame(sample_frame(1));
    const auto before = contents(out.path());
    Frame bad = sample_frame(2);
    bad.totals.kinetic_energy = std::numeric_limits<double>::infinity();
    EXPECT_NE(
        message_of([&] { writer.write_frame(bad); }, kDiverged).find("frame 2: totals.kinetic_energy is not finite"),
        std::string::npos);
    EXPECT_EQ(contents(out.path()), before);
}

TEST(Cache, AFrameWithoutPointsIsAFrame) {
    const TemporaryFolder out;
    CacheWriter writer = CacheWriter::create(out.path(), sample_identity());
    writer.write_frame(sample_frame(0, 0, 0));
    const Frame frame = CacheReader(out.path()).load_frame(0);
    EXPECT_EQ(frame.particles.count, 0u);
    EXPECT_NE(frame.surfels.find("temperature"), nullptr);
}

TEST(Cache, FarFromTheWorldsOriginIsFormat3) {
    const TemporaryFolder out;
    CacheWriter writer = CacheWriter::create(out.path(), sample_identity());
    writer.write_frame(sample_frame(1));
    EXPECT_EQ(CacheReader(out.path()).manifest().format, 1);
    Frame far = sample_frame(2);
    far.particles.origin = far.surfels.origin = {1e6, 0, 5};
    writer.write_frame(far);
    const CacheReader reader(out.path());
    EXPECT_EQ(reader.manifest().format, 3);
    EXPECT_EQ(reader.load_frame(2).surfels.origin, far.surfels.origin);
    EXPECT_TRUE(reader.load_frame(1).surfels.origin.isZero());
}

// tests/golden/cache_format_1 was written by the first program of format 1, as write_sample_cache writes, with these
// frames.
Frame golden_frame(int number) {
    Frame frame = sample_frame(number, 12, 9);
    for (PointSet* points : {&frame.particles, &frame.surfels})  // in one octant, where OpenVDB needs the fewest bytes
        for (Vec3f& p : std::get<std::vector<Vec3f>>(points->attributes[1].data)) p = p.cwiseAbs();
    return frame;
}

TEST(Cache, ACacheOfFormat1StillLoads) {
    const CacheReader reader(fs::path(THIXO_SOURCE_DIR) / "tests/golden/cache_format_1");
    EXPECT_EQ(reader.manifest().format, 1);
    EXPECT_EQ(reader.manifest().scene, "pour");
    EXPECT_TRUE(reader.complete());
    ASSERT_EQ(reader.frames(), (std::vector<int>{1, 2}));
    for (const int n : reader.frames()) {
        const Frame frame = reader.load_frame(n), expected = golden_frame(n);
        expect_same_points(frame.particles, expected.particles);
        expect_same_points(frame.surfels, expected.surfels);
        EXPECT_EQ(frame.totals.mass, 1.0 / 3);
        EXPECT_EQ(frame.bodies.at(1).name, "drop \"3\"");
        EXPECT_EQ(reader.load_asset(frame.obstacles.at(0).asset), "ply\nthe mesh of a glass\n");
    }
}

}  // namespace
}  // namespace thixo::test
