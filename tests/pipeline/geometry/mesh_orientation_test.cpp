#include "pipeline/geometry/mesh_orientation.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "pipeline/geometry/mesh_repair.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/tessellate.h"

namespace thixo {
namespace {

TriangleMesh ring() { return welded(tessellate(torus(0.6, 0.25), 0.1, 12)); }
TriangleMesh ball(double radius, const Vec3d& at = {0, 0, 0}) {
    TriangleMesh mesh = welded(tessellate(sphere(radius), 0.1, 16));
    transform_mesh(mesh, 1, Quatd::Identity(), at);
    return mesh;
}
TriangleMesh flipped(TriangleMesh mesh) {
    flip_mesh(mesh);
    return mesh;
}
TriangleMesh together(TriangleMesh a, const TriangleMesh& b) {
    const Index first = static_cast<Index>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({first + i, first + j, first + k});
    return a;
}
/// Turns triangles by a fixed seed, each with the given chance.
TriangleMesh mixed_up(TriangleMesh mesh, double chance) {
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
        if (random_unit(5, k, 0, 0) < chance) turn_triangle(mesh, k);
    return mesh;
}
std::vector<std::array<Index, 3>> wound(TriangleMesh mesh) {
    orient_outward(mesh);
    return mesh.triangles;
}

TEST(Orientation, LeavesAMeshThatIsSoundAsItWas) {
    for (const TriangleMesh& mesh : {ring(), ball(0.5), together(ball(1), flipped(ball(0.5))), ball(0.5, {4, 0, 0})}) {
        TriangleMesh same = mesh;
        EXPECT_EQ(orient_outward(same), 0u);
        EXPECT_EQ(same.triangles, mesh.triangles);
    }
}

TEST(Orientation, OfEveryTriangleIsFoundWhateverPartOfThemIsTurned) {
    const TriangleMesh good = ring();
    for (const double chance : {0.02, 0.3, 0.5, 0.8, 1.0}) EXPECT_EQ(wound(mixed_up(good, chance)), good.triangles);
}

TEST(Orientation, OfEveryShellIsItsOwn) {
    const TriangleMesh one = ball(0.5), other = ball(0.4, {3, 0, 0});
    const auto good = together(one, other).triangles;
    EXPECT_EQ(wound(together(one, flipped(other))), good);
    EXPECT_EQ(wound(together(flipped(one), flipped(other))), good);
    EXPECT_EQ(wound(together(mixed_up(one, 0.4), flipped(other))), good);
}

TEST(Orientation, KeepsHollowsAndWhatFillsThem) {
    const TriangleMesh outer = ball(1), inner = ball(0.5);
    const auto hollow = together(outer, flipped(inner)).triangles;
    EXPECT_EQ(wound(together(flipped(outer), inner)), hollow);                 // inside out as a whole
    EXPECT_EQ(wound(together(outer, mixed_up(flipped(inner), 0.3))), hollow);  // of mixed winding
    // Two shells wound alike are two bodies that overlap, as before.
    const auto full = together(outer, inner).triangles;
    EXPECT_EQ(wound(together(outer, inner)), full);
    EXPECT_EQ(wound(together(flipped(outer), flipped(inner))), full);
    // The order in the file does not matter.
    EXPECT_EQ(wound(together(flipped(inner), outer)), together(flipped(inner), outer).triangles);
}

TEST(Orientation, OfAnOpenShellFollowsItsLargerPart) {
    TriangleMesh open = ring();
    open.triangles.resize(open.triangles.size() - 4);
    EXPECT_EQ(wound(mixed_up(open, 0.3)), open.triangles);
    EXPECT_EQ(wound(flipped(open)), open.triangles);
}

TEST(Orientation, TakesNormalsAndTextureCoordinatesAlong) {
    const TriangleMesh good = tessellate(box({1, 2, 3}), 1);  // with normals, corners doubled
    ASSERT_EQ(good.normals.size(), good.vertices.size());
    TriangleMesh turned = good;  // triangles turned, normals right
    for (std::size_t k = 0; k < turned.triangles.size(); k += 3) turn_triangle(turned, k);
    orient_outward(turned);
    EXPECT_EQ(turned.triangles, good.triangles);
    EXPECT_EQ(turned.normals, good.normals);
    TriangleMesh inward = flipped(good);  // normals turned with the triangles
    orient_outward(inward);
    EXPECT_EQ(inward.normals, good.normals);
    TriangleMesh textured = ball(0.5);
    for (std::size_t k = 0; k < textured.triangles.size(); ++k)
        textured.uvs.push_back({Vec2f(float(k), 0), Vec2f(float(k), 1), Vec2f(float(k), 2)});
    TriangleMesh back = mixed_up(textured, 0.4);
    orient_outward(back);
    EXPECT_EQ(back.uvs, textured.uvs);
}

TEST(Orientation, EndsOnMeshesThatHaveNone) {
    // A Moebius strip: no winding of all its triangles agrees.
    TriangleMesh strip;
    constexpr Index kParts = 20;
    for (Index k = 0; k < kParts; ++k) {
        const double phi = 2 * kPi * k / kParts;
        for (const double side : {-0.2, 0.2}) {
            const double r = 1 + side * std::cos(phi / 2);
            strip.vertices.push_back(
                Vec3d(r * std::cos(phi), r * std::sin(phi), side * std::sin(phi / 2)).cast<float>());
        }
    }
    for (Index k = 0; k < kParts; ++k) {
        const Index a = 2 * k, b = a + 1, c = k + 1 < kParts ? a + 2 : 1, d = k + 1 < kParts ? a + 3 : 0;
        strip.triangles.push_back({a, c, b});
        strip.triangles.push_back({b, c, d});
    }
    EXPECT_LE(orient_outward(strip), strip.triangles.size());
    EXPECT_GT(inspect_mesh(strip).bad_edges, 0u);
    // Two boxes that share an edge, where four triangles meet: each keeps to itself.
    TriangleMesh boxes = welded(tessellate(box({1, 1, 1}), 1)), other = boxes;
    transform_mesh(other, 1, Quatd::Identity(), {1, 1, 0});
    const auto good = together(boxes, other).triangles;
    EXPECT_EQ(wound(together(boxes, flipped(other))), good);
}

}  // namespace
}  // namespace thixo
