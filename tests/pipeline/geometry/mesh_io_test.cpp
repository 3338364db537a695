#include "pipeline/geometry/mesh_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/base/timer.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/tessellate.h"

namespace thixo {
namespace {

template <class T>
void put(std::string& out, T value, bool big = false) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (big) std::reverse(raw, raw + sizeof(T));
    out.append(raw, sizeof(T));
}

std::string binary_stl(const TriangleMesh& mesh) {
    std::string out(80, ' ');
    out.replace(0, 5, "solid");  // as some programs write it
    put(out, std::uint32_t(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        out.append(12, '\0');
        for (const Index v : t)
            for (int k = 0; k < 3; ++k) put(out, mesh.vertices[v][k]);
        put(out, std::uint16_t(0));
    }
    return out;
}

std::string text_stl(const TriangleMesh& mesh) {
    std::string out = "solid thing\n";
    for (const auto& t : mesh.triangles) {
        out += " facet normal 0 0 0\n  outer loop\n";
        for (const Index v : t)
            out +=
                fmt::format("   vertex {} {} {}\n", mesh.vertices[v].x(), mesh.vertices[v].y(), mesh.vertices[v].z());
        out += "  endloop\n endfacet\n";
    }
    return out + "endsolid thing\n";
}

std::string obj(const TriangleMesh& mesh) {
    std::string out = "# a comment\no thing\r\n";
    for (const Vec3f& v : mesh.vertices) out += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
    for (const auto& t : mesh.triangles)
        out += fmt::format("f {} {}/1 {}\n", t[0] + 1, int(t[1]) - int(mesh.vertices.size()), t[2] + 1);
    return out;
}

std::string big_endian_ply(const TriangleMesh& mesh) {
    std::string out = fmt::format(
        "ply\nformat binary_big_endian 1.0\ncomment x\nelement vertex {}\nproperty double x\nproperty double "
        "y\nproperty double z\nproperty uchar "
        "flag\nelement face {}\nproperty list uchar uint vertex_index\nproperty float weight\nend_header\n",
        mesh.vertices.size(), mesh.triangles.size());
    for (const Vec3f& v : mesh.vertices) {
        for (int k = 0; k < 3; ++k) put(out, double(v[k]), true);
        out.push_back('x');
    }
    for (const auto& t : mesh.triangles) {
        out.push_back(3);
        for (const Index v : t) put(out, v, true);
        put(out, 1.f, true);
    }
    return out;
}

TriangleMesh small_mesh() { return welded(tessellate(torus(0.6, 0.25), 0.1, 12)); }

void expect_same(const TriangleMesh& a, const TriangleMesh& b) {
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.triangles, b.triangles);
}

TEST(MeshFiles, OfEveryKindGiveTheSameMesh) {
    const TriangleMesh mesh = small_mesh();
    expect_same(parse_obj(obj(mesh), "a.obj"), mesh);
    expect_same(parse_ply(write_ply(mesh), "a.ply"), mesh);
    expect_same(parse_ply(big_endian_ply(mesh), "a.ply"), mesh);
    for (const std::string& bytes : {binary_stl(mesh), text_stl(mesh)}) {
        const TriangleMesh stl = parse_stl(bytes, "a.stl");
        EXPECT_EQ(stl.vertices.size(), mesh.vertices.size());  // welded
        EXPECT_TRUE(inspect_mesh(stl).closed);
        EXPECT_NEAR(inspect_mesh(stl).volume, inspect_mesh(mesh).volume, 1e-6);
    }
}

TEST(MeshFiles, WithAByteOrderMarkAreReadAsThoseWithout) {
    const TriangleMesh mesh = small_mesh();
    const std::string mark = "\xef\xbb\xbf";
    expect_same(parse_obj(mark + obj(mesh), "a.obj"), parse_obj(obj(mesh), "a.obj"));
    expect_same(parse_ply(mark + write_ply(mesh), "a.ply"), mesh);
    expect_same(parse_ply(mark + big_endian_ply(mesh), "a.ply"), mesh);
    expect_same(parse_stl(mark + text_stl(mesh), "a.stl"), parse_stl(text_stl(mesh), "a.stl"));
}

TEST(MeshFiles, OfUtf16AreRefusedByThatName) {
    const std::string mark("\xff\xfe", 2);
    for (const auto parse : {parse_obj, parse_ply, parse_stl}) try {
            parse(mark + std::string(200, 'v'), "f", nullptr);
            FAIL();
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find("UTF-16"), std::string::npos) << e.what();
        }
}

/// A text with other line ends.
std::string with_line_ends(const std::string& text, const std::string& end) {
    std::string out;
    for (const char c : text) c == '\n' ? out += end : out += c;
    return out;
}

TEST(MeshFiles, MayEndTheirLinesWithCr) {
    const TriangleMesh mesh = small_mesh();
    for (const std::string end : {"\r", "\r\n"}) {
        std::string text = obj(mesh);
        text.erase(text.find('\r'), 1);
        expect_same(parse_obj(with_line_ends(text, end), "a.obj"), mesh);
        expect_same(parse_stl(with_line_ends(text_stl(mesh), end), "a.stl"), parse_stl(text_stl(mesh), "a.stl"));
        const std::string ply = write_ply(mesh);
        const std::size_t data = ply.find("end_header\n") + 11;
        expect_same(parse_ply(with_line_ends(ply.substr(0, data), end) + ply.substr(data), "a.ply"), mesh);
    }
    // Behind a header whose lines end with CR, a byte of the data that looks like LF is data.
    std::string tiny =
        "ply\rformat binary_little_endian 1.0\relement vertex 1\rproperty char x\rproperty char y\r"
        "property char z\rend_header\r";
    EXPECT_EQ(parse_ply(tiny + "\n\r\x01", "t.ply").vertices.at(0), Vec3f(10, 13, 1));
    // The message counts lines of every kind.
    try {
        parse_obj("v 0 0 0\rv 1 0 0\r\nv 0 1 0\nf 1 2 4\r", "f");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("f: line 4:"), std::string::npos) << e.what();
    }
}

TEST(MeshFiles, KeepTheShapeOfWhatIsFarFromTheOrigin) {
    const auto at = [](double place) {
        std::string text;
        for (int k = 0; k < 8; ++k)
            text += fmt::format("v {:.7f} {:.7f} {:.7f}\n", place + (k & 1 ? 0.1 : -0.1), (k & 2 ? 0.1 : -0.1) - place,
                                k & 4 ? 0.1 : -0.1);
        return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    };
    Vec3d origin(1, 1, 1);
    const TriangleMesh near = parse_obj(at(0), "near.obj", &origin);
    EXPECT_EQ(origin, Vec3d::Zero());  // what is near keeps its coordinates
    EXPECT_NEAR(inspect_mesh(near).volume, 8e-3, 1e-9);
    for (const double place : {1e3, 1e6, 1e8}) {
        const TriangleMesh far = parse_obj(at(place), "far.obj", &origin);
        EXPECT_LT((origin - Vec3d(place, -place, 0)).norm(), 1e-7);
        // The text has seven decimals, doubles at 1e8 have steps of 1.5e-8.
        EXPECT_NEAR(inspect_mesh(far).volume, 8e-3, 8e-3 * 6e-7);
        EXPECT_EQ(far.triangles, near.triangles);
    }
}

TEST(MeshFiles, KeepTextureCoordinatesOfCorners) {
    // Two faces with a seam between them: the shared vertices have other coordinates in each.
    const std::string text =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 0.5\nvt 0.25 0.75\n"
        "f 1/1 2/2 3/3\nf 1/-1 3/2 4/1\n";
    const std::vector<std::array<Vec2f, 3>> uvs = {{Vec2f(0, 0), Vec2f(1, 0), Vec2f(1, 0.5f)},
                                                   {Vec2f(0.25f, 0.75f), Vec2f(1, 0), Vec2f(0, 0)}};
    const TriangleMesh mesh = parse_obj(text, "a.obj");
    EXPECT_EQ(mesh.uvs, uvs);
    const TriangleMesh back = parse_ply(write_ply(mesh), "a.ply");
    expect_same(back, mesh);
    EXPECT_EQ(back.uvs, uvs);
    // A quad is cut with its coordinates; of vertices they go to the corners.
    const TriangleMesh quad = parse_ply(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "property float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0 0 0\n2 0 0 1 0\n2 2 0 1 1\n0 2 0 0 1\n4 0 1 2 3\n",
        "q.ply");
    ASSERT_EQ(quad.uvs.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k)
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_EQ(quad.uvs[k][c], Vec2f(quad.vertices[quad.triangles[k][c]].head<2>() / 2));
    // A mesh has none where one of its faces has none. References to missing coordinates do no harm.
    EXPECT_TRUE(parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\nf 1 2 3\n", "a.obj").uvs.empty());
    EXPECT_TRUE(parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2/2 3/3\n", "a.obj").uvs.empty());
}

TEST(MeshFiles, AreReadByTheirExtension) {
    const auto folder = std::filesystem::temp_directory_path() / "thixo_mesh_io_test";
    std::filesystem::create_directories(folder);
    const TriangleMesh mesh = tessellate(box({1, 2, 3}), 1);
    std::ofstream(folder / "box.PLY", std::ios::binary) << write_ply(mesh);
    const TriangleMesh back = read_mesh((folder / "box.PLY").string());
    expect_same(back, mesh);
    EXPECT_EQ(back.normals, mesh.normals);
    std::ofstream(folder / "empty.obj").flush();
    EXPECT_THROW(read_mesh((folder / "empty.obj").string()), InputError);
    EXPECT_THROW(read_mesh((folder / "none.obj").string()), InputError);
    EXPECT_THROW(read_mesh(folder.string()), InputError);
    EXPECT_THROW(read_mesh((folder / "box.fbx").string()), InputError);
    std::filesystem::remove_all(folder);
}

TEST(Ply, StripsAreUnrolledAlternatelyAndRestartAtMinusOne) {
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n";
    const TriangleMesh mesh = parse_ply(header + "9 0 1 2 3 4 -1 0 1 2\n", "a.ply");
    const std::vector<std::array<Index, 3>> expected = {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {0, 1, 2}};
    EXPECT_EQ(mesh.triangles, expected);
    // A repeated corner adds no triangle but keeps the alternation.
    const TriangleMesh swap = parse_ply(header + "5 0 1 2 2 3\n", "a.ply");
    const std::vector<std::array<Index, 3>> kept = {{0, 1, 2}};
    EXPECT_EQ(swap.triangles, kept);
}

TEST(Ply, FacesMayStandBeforeTheVertices) {
    const std::string head = "ply\nformat ascii 1.0\n", end = "end_header\n",
                      vertices = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n",
                      faces = "element face 1\nproperty list uchar int vertex_indices\n",
                      places = "0 0 0\n2 0 0\n2 2 0\n0 2 0\n", quad = "4 0 1 2 3\n";
    const TriangleMesh usual = parse_ply(head + vertices + faces + end + places + quad, "a.ply"),
                       other = parse_ply(head + faces + vertices + end + quad + places, "b.ply");
    expect_same(usual, other);
    ASSERT_EQ(other.triangles.size(), 2u);
    EXPECT_THROW(parse_ply(head + faces + vertices + end + "4 0 1 2 4\n" + places, "c.ply"), InputError);
}

TEST(Stl, OfTextMayBeWrittenInCapitalsAndBehindBlanks) {
    const TriangleMesh mesh = small_mesh();
    const std::string text = text_stl(mesh);
    std::string capitals = text;
    for (char& c : capitals)
        if (c != 'e') c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));  // 1e-05 as it was
    expect_same(parse_stl(capitals, "a.stl"), parse_stl(text, "a.stl"));
    expect_same(parse_stl("\n  " + text, "a.stl"), parse_stl(text, "a.stl"));
    // A part may be called as the keywords are.
    std::string named = text;
    named.replace(0, 11, "solid facet vertex 1");
    expect_same(parse_stl(named, "a.stl"), parse_stl(text, "a.stl"));
}

TEST(Stl, OfBytesIsToldByItsCountWhateverItsHeaderSays) {
    const TriangleMesh mesh = small_mesh();
    const std::string bytes = binary_stl(mesh);  // its header begins with "solid"
    const TriangleMesh whole = parse_stl(bytes, "a.stl");
    for (const std::string trail :
         {std::string(1, '\0'), std::string(49, 'x'), std::string("\r\n"), std::string(400, ' ')})
        expect_same(parse_stl(bytes + trail, "a.stl"), whole);
    try {
        parse_stl(bytes.substr(0, bytes.size() - 1), "a.stl");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("cut short"), std::string::npos) << e.what();
    }
}

TEST(Ply, PointSetsKeepNormalsAndColours) {
    const TriangleMesh mesh = parse_ply(
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float "
        "nx\nproperty float ny\n"
        "property float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n0 0 0 0 0 2 255 "
        "0 0\n1 0 0 0 3 4 0 255 188\n",
        "a.ply");
    EXPECT_TRUE(mesh.triangles.empty());
    ASSERT_EQ(mesh.normals.size(), 2u);
    EXPECT_LT((mesh.normals[1] - Vec3f(0, 0.6f, 0.8f)).norm(), 1e-6f);
    EXPECT_NEAR(mesh.colours[1].z(), 0.5029, 1e-3);  // sRGB 188/255
    const TriangleMesh again = parse_ply(write_ply(mesh), "b.ply");
    EXPECT_EQ(again.normals, mesh.normals);
    EXPECT_EQ(again.colours, mesh.colours);
}

TEST(Polygons, AreCutWithinTheirOutline) {
    // An L of area 3: a fan from its first corner would cover ground outside of it.
    const TriangleMesh mesh =
        parse_obj("v 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nf 1 2 3 4 5 6\n", "l.obj");
    ASSERT_EQ(mesh.triangles.size(), 4u);
    double area = 0;
    for (const auto& t : mesh.triangles) {
        const Vec3f n = (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
        EXPECT_GT(n.z(), 0);
        area += n.z() / 2;
    }
    EXPECT_NEAR(area, 3, 1e-6);
}

TEST(Obj, NormalsAreKeptWhereEachVertexHasOne) {
    const std::string head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\nvn 0 1 0\n";
    EXPECT_EQ(parse_obj(head + "f 1//1 2//1 3//2\nf 2//1 4//1 3//2\n", "a.obj").normals.size(), 4u);
    EXPECT_TRUE(parse_obj(head + "f 1//1 2//1 3//2\nf 2//2 4//1 3//2\n", "a.obj").normals.empty());
}

TEST(MeshReport, FindsHolesSliversAndTheInsideOut) {
    TriangleMesh mesh = small_mesh();
    EXPECT_TRUE(inspect_mesh(mesh).closed);
    EXPECT_NEAR(inspect_mesh(tessellate(box({1, 2, 3}), 1)).volume, 6, 1e-6);
    EXPECT_TRUE(inspect_mesh(tessellate(box({1, 2, 3}), 1)).closed);  // sharp edges have doubled vertices
    flip_mesh(mesh);
    EXPECT_LT(inspect_mesh(mesh).volume, 0);
    mesh.triangles.pop_back();
    EXPECT_EQ(inspect_mesh(mesh).open_edges, 3u);
    mesh.triangles.push_back(mesh.triangles[0]);
    EXPECT_EQ(inspect_mesh(mesh).bad_edges, 3u);
    mesh.triangles.push_back({0, 0, 1});
    EXPECT_EQ(inspect_mesh(mesh).degenerate_triangles, 1u);
}

using Parser = TriangleMesh (*)(std::string_view, const std::string&, Vec3d*);

std::string message(Parser parse, const std::string& bytes) {
    try {
        parse(bytes, "f", nullptr);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST(DamagedMeshes, AreRefusedWithThePlace) {
    EXPECT_NE(message(parse_obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n").find("f: line 4:"), std::string::npos);
    EXPECT_NE(message(parse_obj, "v 0 0\n").find("f: line 1:"), std::string::npos);
    EXPECT_NE(message(parse_obj, "\nv 0 nan 0\n").find("f: line 2:"), std::string::npos);
    EXPECT_NE(message(parse_obj, "hello\n"), "");
    const std::string ply = write_ply(small_mesh());
    EXPECT_NE(message(parse_ply, ply.substr(0, ply.size() - 5)).find("byte"), std::string::npos);
    std::string giant = ply;
    giant.replace(giant.find("element vertex 144"), 18, "element vertex 999999999999");
    EXPECT_NE(message(parse_ply, giant).find("do not fit"), std::string::npos);
    EXPECT_NE(message(parse_ply,
                      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
                      "z\nend_header\n1 2 inf\n")
                  .find("line 8"),
              std::string::npos);
    std::string stl = binary_stl(small_mesh());
    EXPECT_NE(message(parse_stl, stl.substr(0, 60)), "");
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(stl.data() + 84 + 50 * 3 + 16, &nan, 4);
    EXPECT_NE(message(parse_stl, stl).find("triangle 4"), std::string::npos);
    EXPECT_NE(message(parse_stl, "solid x\nendsolid x\n"), "");
}

/// Cuts, flips, overwrites or repeats parts of a good file, by a fixed seed.
std::string damaged(const std::string& good, std::uint64_t seed) {
    const auto pick = [&](std::uint64_t use, std::size_t n) {
        return std::size_t(random_unit(11, seed, 0, use) * double(n));
    };
    std::string bytes = good;
    switch (seed % 4) {
        case 0:
            bytes.resize(pick(0, good.size()));
            break;
        case 1:
            for (int k = 0; k < 8; ++k) bytes[pick(2 * k, good.size())] ^= char(1 << pick(2 * k + 1, 8));
            break;
        case 2:  // the header or first lines: counts and keys
            for (int k = 0; k < 3; ++k)
                bytes[pick(2 * k, std::min<std::size_t>(good.size(), 300))] = "0123456789- \n.eE"[pick(2 * k + 1, 16)];
            break;
        case 3: {
            const std::size_t from = pick(0, good.size()), to = pick(1, good.size()), length = pick(2, 200);
            bytes.insert(to, good.substr(from, length));
        }
    }
    return bytes;
}

TEST(DamagedMeshes, NeverCrashTheReaders) {
    const TriangleMesh mesh = small_mesh();
    struct Kind {
        Parser parse;
        std::string bytes;
    };
    const std::vector<Kind> kinds = {{parse_obj, obj(mesh)},
                                     {parse_ply, write_ply(mesh)},
                                     {parse_ply, big_endian_ply(mesh)},
                                     {parse_stl, binary_stl(mesh)},
                                     {parse_stl, text_stl(mesh)}};
    int refused = 0, read = 0;
    const double start = wall_seconds();
    for (const Kind& kind : kinds)
        for (std::uint64_t seed = 0; seed < 2000; ++seed) try {
                const TriangleMesh m = kind.parse(damaged(kind.bytes, seed), "fuzz", nullptr);
                for (const auto& t : m.triangles)
                    for (const Index v : t) ASSERT_LT(v, m.vertices.size());
                for (const Vec3f& v : m.vertices) ASSERT_TRUE(v.allFinite());
                inspect_mesh(m);
                ++read;
            } catch (const InputError&) {
                ++refused;
            }
    EXPECT_GT(refused, 1000);
    EXPECT_GT(read, 1000);
    EXPECT_LT(wall_seconds() - start, 60);  // a damaged count must not stall; about 1 s on an idle core
}

}  // namespace
}  // namespace thixo
