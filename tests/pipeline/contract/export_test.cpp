#include "pipeline/contract/export.h"

#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::test {
namespace {

PointSet three_points() {
    PointSet points;
    points.count = 3;
    points.add("P", std::vector<Vec3f>{{1, 2, 3}, {0.1f, -0.2f, 1e-9f}, {4, 5, 6}});
    points.add("id", std::vector<std::int64_t>{30, (std::int64_t(1) << 40) + 1, 10});
    points.add("pscale", std::vector<float>{0.5f, 1.0f / 3, 0.25f});
    points.add("N", std::vector<Vec3f>{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}});
    points.add("body", std::vector<std::int32_t>{-1, 2, 3});
    return points;
}

template <class T>
T value_at(const std::string& bytes, std::size_t at) {
    T value;
    EXPECT_LE(at + sizeof(T), bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}

TEST(Export, CsvHasAttributeNamesAndARowAPointInOrderOfIds) {
    EXPECT_EQ(export_points(three_points(), ExportFormat::csv),
              "P.x,P.y,P.z,id,pscale,N.x,N.y,N.z,body\n"
              "4,5,6,10,0.25,1,0,0,3\n"
              "1,2,3,30,0.5,0,0,1,-1\n"
              "0.1,-0.2,1e-09,1099511627777,0.33333334,0,1,0,2\n");
}

TEST(Export, PlacesFarFromTheWorldsOriginAreDoubles) {
    PointSet points;
    points.count = 1;
    points.origin = {1e6, 0, -2e5};
    points.add("P", std::vector<Vec3f>{{0.125f, 2, 0.5f}});
    points.add("v", std::vector<Vec3f>{{1, 2, 3}});
    points.add("rest", std::vector<Vec3f>{{0, 0, 0.25f}});
    EXPECT_EQ(export_points(points, ExportFormat::csv),
              "P.x,P.y,P.z,v.x,v.y,v.z,rest.x,rest.y,rest.z\n"
              "1000000.125,2,-199999.5,1,2,3,1000000,0,-199999.75\n");
    const std::string ply = export_points(points, ExportFormat::ply);
    for (const char* line : {"property double x\n", "property float v_x\n", "property double rest_z\n"})
        EXPECT_NE(ply.find(line), std::string::npos) << line;
    const std::size_t row = 3 * 8 + 3 * 4 + 3 * 8;
    EXPECT_EQ(value_at<double>(ply, ply.size() - row), 1000000.125);
    EXPECT_EQ(value_at<float>(ply, ply.size() - row + 24), 1.0f);
    EXPECT_EQ(value_at<double>(ply, ply.size() - 8), -199999.75);
    const std::string vtp = export_points(points, ExportFormat::vtp);
    EXPECT_NE(vtp.find("type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\""), std::string::npos);
    EXPECT_NE(vtp.find("type=\"Float32\" Name=\"v\""), std::string::npos);
}

TEST(Export, CsvNumbersReadBackToTheSameBits) {
    const PointSet points = sample_points(500, 5);
    std::istringstream csv(export_points(points, ExportFormat::csv));
    std::string line;
    std::getline(csv, line);
    EXPECT_EQ(line, "id,P.x,P.y,P.z,v.x,v.y,v.z,temperature,body");
    for (std::size_t i = 0; i < points.count; ++i) {
        std::getline(csv, line);
        std::istringstream cells(line);
        std::vector<std::string> cell;
        for (std::string c; std::getline(cells, c, ',');) cell.push_back(c);
        ASSERT_EQ(cell.size(), 9u);
        ASSERT_EQ(std::stoll(cell[0]), points.get<std::int64_t>("id")[i]);
        for (int c = 0; c < 3; ++c)
            ASSERT_EQ(std::stof(cell[1 + static_cast<std::size_t>(c)]), points.get<Vec3f>("P")[i][c]);
        ASSERT_EQ(std::stof(cell[7]), points.get<float>("temperature")[i]);
    }
}

TEST(Export, PlyHasPositionNormalRadiusThenTheRest) {
    const std::string ply = export_points(three_points(), ExportFormat::ply);
    const std::string header =
        "ply\nformat binary_little_endian 1.0\ncomment Thixo\nelement vertex 3\n"
        "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float "
        "nz\n"
        "property float radius\nproperty double id\nproperty int body\nend_header\n";
    ASSERT_TRUE(ply.starts_with(header)) << ply.substr(0, header.size());
    const std::size_t row = 7 * 4 + 8 + 4;
    ASSERT_EQ(ply.size(), header.size() + 3 * row);
    const std::size_t last = header.size() + 2 * row;  // the largest id
    EXPECT_EQ(value_at<float>(ply, last), 0.1f);
    EXPECT_EQ(value_at<float>(ply, last + 16), 1.0f);
    EXPECT_EQ(value_at<float>(ply, last + 24), 1.0f / 3);
    EXPECT_EQ(value_at<double>(ply, last + 28), 1099511627777.0);
    EXPECT_EQ(value_at<std::int32_t>(ply, last + 36), 2);
}

TEST(Export, VtpArraysLieWhereTheirOffsetsSay) {
    const std::string vtp = export_points(three_points(), ExportFormat::vtp);
    const std::string mark = "<AppendedData encoding=\"raw\">\n_";
    const std::size_t data = vtp.find(mark) + mark.size();
    ASSERT_LT(data, vtp.size());
    const auto array = [&](const std::string& name) {
        const std::size_t at = vtp.find("Name=\"" + name + "\"");
        EXPECT_NE(at, std::string::npos) << name;
        const std::size_t offset = vtp.find("offset=\"", at) + 8;
        return data + std::stoul(vtp.substr(offset, 20));
    };
    EXPECT_EQ(value_at<std::uint64_t>(vtp, array("Points")), 36u);
    EXPECT_EQ(value_at<float>(vtp, array("Points") + 8), 4.0f);
    EXPECT_EQ(value_at<std::uint64_t>(vtp, array("id")), 24u);
    EXPECT_EQ(value_at<std::int64_t>(vtp, array("id") + 8 + 16), 1099511627777);
    EXPECT_EQ(value_at<std::int32_t>(vtp, array("body") + 8), 3);
    EXPECT_EQ(value_at<std::int64_t>(vtp, array("offsets") + 8 + 16), 3);
    EXPECT_EQ(value_at<std::int64_t>(vtp, array("connectivity") + 8 + 16), 2);
    EXPECT_TRUE(vtp.ends_with("\n</AppendedData>\n</VTKFile>\n"));
    EXPECT_EQ(vtp.size() - std::string("\n</AppendedData>\n</VTKFile>\n").size(), array("offsets") + 8 + 24);
}

TEST(Export, WritesAFileAFrameAndACollectionWithTimes) {
    const TemporaryFolder out;
    write_sample_cache(out.path(), 3);
    const CacheReader reader(out.path());
    for (const auto what : {ExportWhat::particles, ExportWhat::surfels}) {
        const std::string kind = what == ExportWhat::particles ? "particles" : "surfels";
        const auto files = export_cache(reader, {1, 3}, ExportFormat::vtp, what, out / "vtp");
        ASSERT_EQ(files.size(), 3u);
        EXPECT_EQ(files[1], out / "vtp" / (kind + ".0003.vtp"));
        const std::string pvd = read_whole(out / "vtp" / (kind + ".pvd"));
        EXPECT_NE(pvd.find("<DataSet timestep=\"0.125\" part=\"0\" file=\"" + kind + ".0003.vtp\"/>"),
                  std::string::npos)
            << pvd;
    }
    EXPECT_EQ(export_cache(reader, {2}, ExportFormat::csv, ExportWhat::surfels, out / "csv").size(), 1u);
    EXPECT_EQ(read_whole(out / "csv/surfels.0002.csv"), export_points(reader.load_surfels(2), ExportFormat::csv));
    EXPECT_NE(
        message_of([&] { export_cache(reader, {9}, ExportFormat::ply, ExportWhat::surfels, out / "ply"); }, kBadCache)
            .find("no frame 9"),
        std::string::npos);
}

TEST(Export, AnEmptySetIsAFile) {
    for (const auto format : {ExportFormat::ply, ExportFormat::vtp, ExportFormat::csv})
        EXPECT_FALSE(export_points(PointSet(), format).empty());
    EXPECT_EQ(export_points(sample_points(0, 1), ExportFormat::csv), "id,P.x,P.y,P.z,v.x,v.y,v.z,temperature,body\n");
}

TEST(Export, UnknownWordsAreRefused) {
    EXPECT_EQ(parse_export_format("vtp"), ExportFormat::vtp);
    EXPECT_EQ(parse_export_what("surfels"), ExportWhat::surfels);
    EXPECT_NE(message_of([] { parse_export_format("abc"); }, kBadInput).find("'abc'"), std::string::npos);
    EXPECT_NE(message_of([] { parse_export_what("air"); }, kBadInput).find("'air'"), std::string::npos);
}

}  // namespace
}  // namespace thixo::test
