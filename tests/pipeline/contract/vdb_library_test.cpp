// Point files are OpenVDB's: its own reader finds the same points in them as ours, so that other tools read them.
#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointDataGrid.h>

#include <sstream>

#include "pipeline/contract/vdb_points.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

namespace vdb = openvdb;
namespace vp = openvdb::points;

void expect_open_vdb_reads(PointSet points) {
    points.add("density", std::vector<float>(points.count, 1000));  // equal in every leaf
    const std::string bytes = encode_points(points, "particles", 0.25);
    const PointSet ours = decode_points(bytes, "file");
    std::istringstream in(bytes);
    const auto grid = vdb::gridPtrCast<vp::PointDataGrid>(vdb::io::Stream(in).getGrids()->front());
    const auto& id = ours.get<std::int64_t>("id");
    const auto &position = ours.get<Vec3f>("P"), &velocity = ours.get<Vec3f>("v");
    const auto &temperature = ours.get<float>("temperature"), &density = ours.get<float>("density");
    const auto& body = ours.get<std::int32_t>("body");
    std::size_t k = 0;
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
        const vp::AttributeHandle<vdb::Vec3f> p(leaf->constAttributeArray("P")), v(leaf->constAttributeArray("v"));
        const vp::AttributeHandle<std::int64_t> i(leaf->constAttributeArray("id"));
        const vp::AttributeHandle<float> t(leaf->constAttributeArray("temperature")),
            d(leaf->constAttributeArray("density"));
        const vp::AttributeHandle<std::int32_t> b(leaf->constAttributeArray("body"));
        for (auto at = leaf->beginIndexOn(); at; ++at, ++k) {
            ASSERT_LT(k, ours.count);
            const vdb::Vec3d x = grid->indexToWorld(at.getCoord().asVec3d() + vdb::Vec3d(p.get(*at)));
            // Of a double near `origin` as much is left.
            const Vec3d local = Vec3d(x[0], x[1], x[2]) - points.origin;
            if (points.origin.isZero())
                ASSERT_EQ(position[k], local.cast<float>());
            else
                ASSERT_LT((position[k].cast<double>() - local).norm(), 1e-9);
            ASSERT_EQ(velocity[k], Vec3f(v.get(*at)[0], v.get(*at)[1], v.get(*at)[2]));
            ASSERT_EQ(id[k], i.get(*at));
            ASSERT_EQ(temperature[k], t.get(*at));
            ASSERT_EQ(density[k], d.get(*at));
            ASSERT_EQ(body[k], b.get(*at));
        }
    }
    EXPECT_EQ(k, ours.count);
    EXPECT_EQ(k, points.count);
    EXPECT_EQ(ours.origin, points.origin);
}

TEST(PointFiles, AreReadByOpenVdbToTheSameBits) { expect_open_vdb_reads(sample_points(30'000, 5)); }

TEST(PointFiles, OfPointsFarFromTheWorldsOriginAreReadByOpenVdbWhereTheyAre) {
    PointSet points = sample_points(1000, 6);
    points.origin = {1e6, -3e5, 700};
    expect_open_vdb_reads(points);
}

}  // namespace
}  // namespace thixo::test
