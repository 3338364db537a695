#include "pipeline/contract/vdb_points.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <limits>
#include <set>

#include "tests/pipeline/contract/cache_fixture.h"
#include "tests/pipeline/contract/mutated.h"

namespace thixo::test {
namespace {

constexpr double kVoxel = 0.0625;

TEST(VdbPoints, KeepsEveryBitOfEveryPoint) {
    const PointSet points = sample_points(20'000, 1);
    const PointSet read = decode_points(encode_points(points, "particles", kVoxel), "file");
    expect_same_points(points, read);  // P too: a voxel edge that is a power of two costs no rounding
    EXPECT_EQ(read.attributes[0].name, "P");
}

TEST(VdbPoints, AnOriginFarAwayCostsNoBit) {
    PointSet points = sample_points(2000, 7);
    points.origin = {1e6, 0.1, -1e9};
    const PointSet read = decode_points(encode_points(points, "particles", kVoxel), "file");
    expect_same_points(points, read);
    EXPECT_EQ(read.origin, points.origin);
    points.count = 0;
    for (Attribute& a : points.attributes) std::visit([](auto& v) { v.clear(); }, a.data);
    EXPECT_EQ(decode_points(encode_points(points, "particles", kVoxel), "file").origin, points.origin);
}

TEST(VdbPoints, TheVoxelEdgeIsAPowerOfTwoUpToTwiceTheSpacing) {
    for (const double spacing : {0.001, 0.01, 0.03125, 0.5, 1.0, 7.3}) {
        const double voxel = voxel_size_for(spacing);
        int exponent = 0;
        EXPECT_EQ(std::frexp(voxel, &exponent), 0.5);
        EXPECT_LE(voxel, 2 * spacing);
        EXPECT_GT(voxel, spacing);
    }
}

TEST(VdbPoints, AMicrometreApartKeepEveryBit) {
    for (const double spacing : {1e-5, 5e-6, 1e-6}) {
        PointSet points = sample_points(2000, 3);
        for (Vec3f& p : std::get<std::vector<Vec3f>>(points.attributes[1].data)) p *= static_cast<float>(20 * spacing);
        expect_same_points(points, decode_points(encode_points(points, "particles", voxel_size_for(spacing)), "file"));
    }
}

TEST(VdbPoints, OtherVoxelEdgesRoundPositionsByMuchLessThanAVoxel) {
    const double voxel = 0.03;
    const PointSet points = sample_points(5000, 2);
    const PointSet read = decode_points(encode_points(points, "particles", voxel), "file");
    const auto &a = points.get<Vec3f>("P"), &b = read.get<Vec3f>("P");
    const auto row_a = by_id(points), row_b = by_id(read);
    for (std::size_t k = 0; k < points.count; ++k) {
        // Half a unit in the last place of a float below 0.5 voxel, and of the result (below 1).
        const double bound = std::ldexp(voxel, -26) + std::ldexp(1.0, -25);
        ASSERT_LE((a[row_a[k]].cast<double>() - b[row_b[k]].cast<double>()).cwiseAbs().maxCoeff(), bound);
    }
}

TEST(VdbPoints, ExtremeValuesSurvive) {
    PointSet points;
    points.count = 4;
    const float big = std::numeric_limits<float>::max(), tiny = std::numeric_limits<float>::denorm_min();
    points.add("P", std::vector<Vec3f>{{0, 0, 0}, {-0.03125f, 0.03125f, 1e-30f}, {4e5f, -4e5f, 0}, {1, 1, 1}});
    points.add("id", std::vector<std::int64_t>{1, 2, 3, std::numeric_limits<std::int64_t>::max()});
    points.add("a", std::vector<float>{big, -big, tiny, 0});
    points.add("b", std::vector<std::int32_t>{INT32_MIN, INT32_MAX, 0, -1});
    expect_same_points(points, decode_points(encode_points(points, "x", kVoxel), "file"));
}

TEST(VdbPoints, EqualSetsGiveEqualBytesAtAnyThreadCount) {
    const PointSet points = sample_points(50'000, 3);
    const std::string bytes = encode_points(points, "particles", kVoxel);
    for (const std::size_t threads : {1, 2, 3}) {
        const oneapi::tbb::global_control limit(oneapi::tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_TRUE(encode_points(points, "particles", kVoxel) == bytes) << threads << " threads";
    }
}

TEST(VdbPoints, PointsComeVoxelByVoxel) {
    const PointSet read = decode_points(encode_points(sample_points(20'000, 4), "particles", kVoxel), "file");
    std::set<std::array<int, 3>> left;
    std::array<int, 3> now{INT32_MAX, 0, 0};
    for (const Vec3f& p : read.get<Vec3f>("P")) {
        std::array<int, 3> voxel;
        for (int c = 0; c < 3; ++c)
            voxel[static_cast<std::size_t>(c)] = static_cast<int>(std::floor(p[c] / kVoxel + 0.5));
        if (voxel == now) continue;
        ASSERT_TRUE(left.insert(voxel).second) << "a voxel was left and entered again";
        now = voxel;
    }
    EXPECT_GT(left.size(), 10'000u);
}

TEST(VdbPoints, PointsOfOneVoxelKeepTheirOrder) {
    PointSet points;
    points.count = 3;
    points.add("P", std::vector<Vec3f>(3, Vec3f(0.5f, 0.5f, 0.5f)));
    points.add("id", std::vector<std::int64_t>{9, 2, 5});
    const PointSet read = decode_points(encode_points(points, "x", kVoxel), "file");
    EXPECT_EQ(read.get<std::int64_t>("id"), (std::vector<std::int64_t>{9, 2, 5}));
}

TEST(VdbPoints, AnEmptySetKeepsItsAttributes) {
    const PointSet read = decode_points(encode_points(sample_points(0, 1), "particles", kVoxel), "file");
    EXPECT_EQ(read.count, 0u);
    EXPECT_EQ(read.get<std::int64_t>("id").size(), 0u);
    EXPECT_EQ(read.get<Vec3f>("v").size(), 0u);
    EXPECT_EQ(read.get<std::int32_t>("body").size(), 0u);
    EXPECT_TRUE(decode_points(encode_points(PointSet(), "particles", kVoxel), "file").attributes.empty());
}

TEST(VdbPoints, ValuesThatAreNotFiniteAreRefusedByName) {
    PointSet points = sample_points(10, 1);
    std::get<std::vector<Vec3f>>(points.attributes[2].data)[4].y() = std::numeric_limits<float>::quiet_NaN();
    const std::string message = message_of([&] { encode_points(points, "particles", kVoxel); }, kDiverged);
    EXPECT_NE(message.find("attribute v of the point id 1099511627780 is not finite"), std::string::npos) << message;
}

TEST(VdbPoints, APointTooFarForItsSpacingIsRefusedByName) {
    PointSet points = sample_points(10, 1);
    std::get<std::vector<Vec3f>>(points.attributes[1].data)[4] = {0, 0, -1e7f};
    const std::string message = message_of([&] { encode_points(points, "particles", kVoxel); }, kDiverged);
    EXPECT_NE(message.find("id 1099511627780 is 10000000 m away"), std::string::npos) << message;
}

TEST(VdbPoints, EveryFlippedBitAndEveryTruncationIsFound) {
    const std::string bytes = encode_points(sample_points(5, 1), "particles", kVoxel);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::string flipped = bytes;
        flipped[i] = static_cast<char>(flipped[i] ^ (1 << (i % 8)));
        ASSERT_NE(message_of([&] { decode_points(flipped, "the file"); }, kBadCache).find("the file"),
                  std::string::npos)
            << i;
        ASSERT_NE(message_of([&] { decode_points(bytes.substr(0, i), "the file"); }, kBadCache).find("the file"),
                  std::string::npos)
            << i;
    }
}

/// What a file with the right checksum gives: points of which all is there, or an error that names the file. True: points.
bool is_read(const std::string& bytes) {
    try {
        const PointSet read = decode_points(sealed_points(bytes), "the file");
        for (const Attribute& a : read.attributes)
            std::visit([&](const auto& values) { EXPECT_EQ(values.size(), read.count) << a.name; }, a.data);
        return true;
    } catch (const CacheError& e) {
        EXPECT_NE(std::string(e.what()).find("the file"), std::string::npos) << e.what();
        return false;
    }
}

/// Two leaves of points, one attribute that is equal everywhere.
std::string small_file() {
    PointSet points = sample_points(20, 6);
    for (Vec3f& p : std::get<std::vector<Vec3f>>(points.attributes[1].data))
        p = p.cwiseProduct(Vec3f(0.4f, 0.2f, 0.2f)) + Vec3f(0, 0.25f, 0.25f);
    points.add("density", std::vector<float>(points.count, 1000));
    return encode_points(points, "particles", kVoxel);
}

TEST(CraftedPoints, ALengthThatIsAnotherIsAnError) {
    const std::string bytes = small_file();
    // The tree's masks, 10 kB of nearly only zeros, are tried more rarely.
    std::size_t refused = 0, step = 1;
    for (std::size_t at = 57; at < bytes.size(); at += step) {
        step = bytes.compare(at, 64, std::string(64, '\0')) == 0 ? 16 : 1;
        for (const std::int32_t number : {0, -1, 1000, INT32_MAX}) {
            std::string crafted = bytes;
            std::memcpy(crafted.data() + at, &number, std::min(sizeof number, bytes.size() - at));
            refused += !is_read(crafted);
        }
    }
    EXPECT_GT(refused, bytes.size() / 10);
}

TEST(CraftedPoints, AChangedFileIsReadOrRefused) {
    const std::string bytes = small_file();
    const std::uint64_t rounds = fuzz_rounds(2000);
    std::uint64_t refused = 0;
    for (std::uint64_t k = 0; k < rounds; ++k) refused += !is_read(mutated(bytes, 20260101, k));
    EXPECT_GT(refused, rounds / 4);
}

TEST(CraftedPoints, MoreValuesThanFitIntoTheFileAreRefused) {
    // Leaves of many equal points: each attribute is stored as one value.
    PointSet points;
    points.count = 2'000'000;
    points.add("P", std::vector<Vec3f>(points.count, Vec3f(0.5f, 0.5f, 0.5f)));
    points.add("v", std::vector<Vec3f>(points.count, Vec3f(1, 0, 0)));
    const std::string bytes = encode_points(points, "x", kVoxel);
    ASSERT_LT(bytes.size(), 20'000u);
    EXPECT_NE(message_of([&] { decode_points(bytes, "the file"); }, kBadCache).find("fit into its size"),
              std::string::npos);
}

}  // namespace
}  // namespace thixo::test
