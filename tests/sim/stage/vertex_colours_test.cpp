// The colours of a mesh's vertices: on the surfels of bodies, and on obstacles.
#include <gtest/gtest.h>

#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/scene_io.h"
#include "sim/loop/step.h"
#include "sim/stage/boundary_mesh.h"
#include "sim/stage/frame_output.h"
#include "sim/stage/setup.h"
#include "tests/pipeline/driver/temporary_folder.h"

namespace thixo {
namespace {

/// A cube with an edge of 0.2 m about the origin. It is red where x < 0, and blue where x > 0.
std::string coloured_cube() {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n";
    for (const char* c : {"red", "green", "blue"}) text += std::string("property uchar ") + c + "\n";
    text += "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
    for (int k = 0; k < 8; ++k)
        text += fmt::format("{} {} {} {}\n", k & 1 ? 0.1 : -0.1, k & 2 ? 0.1 : -0.1, k & 4 ? 0.1 : -0.1,
                            k & 1 ? "0 0 255" : "255 0 0");
    return text + "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";
}

class VertexColours : public testing::Test {
  protected:
    scene::Scene parse(const std::string& text) {
        write_whole(folder_.path / "cube.ply", coloured_cube());
        return scene::parse_scene(text + "\nsolver: {spacing: 0.02}\n", (folder_.path / "scene.yaml").string());
    }
    /// Every surfel has the colour of where it was made: interpolated along x. `off` [m]: how far surfels stand off the
    /// mesh; the colour is that of its nearest point.
    static void expect_colours(const Frame& frame, double off) {
        const auto& colour = frame.surfels.get<Vec3f>("Cd");
        const auto& rest = frame.surfels.get<Vec3f>("rest");
        ASSERT_GT(colour.size(), 100u);
        for (std::size_t i = 0; i < colour.size(); ++i) {
            const float x = std::clamp(rest[i].x() / 0.1f, -1.0f, 1.0f);
            EXPECT_NEAR(colour[i].x(), (1 - x) / 2, off / 0.2 + 1e-4) << rest[i].transpose();
            EXPECT_NEAR(colour[i].z(), (1 + x) / 2, off / 0.2 + 1e-4) << rest[i].transpose();
        }
    }
    Frame first_frame(const scene::Scene& scene) {
        Simulation sim = make_simulation(scene);
        refresh_surface(sim);
        evaluate(sim);
        return make_frame(sim, {}, coloured_shapes(sim.problem.scene));
    }
    TemporaryFolder folder_;
};

TEST_F(VertexColours, OfASolidAreOnItsSurfels) {
    expect_colours(first_frame(parse("materials: {m: {youngs_modulus: 1e5}}\n"
                                     "bodies: {b: {material: m, shape: {mesh: {file: cube.ply, scale: 1}}}}")),
                   0);
}

TEST_F(VertexColours, OfALiquidAreOnItsSurfels) {
    expect_colours(first_frame(parse("materials: {m: {}}\n"
                                     "bodies: {b: {material: m, shape: {mesh: {file: cube.ply, scale: 1}}}}")),
                   0.02);  // a spacing
}

TEST_F(VertexColours, AreTheMeshsWhereItIsMovedAndCombined) {
    const Frame frame = first_frame(parse(
        "materials: {m: {youngs_modulus: 1e5}}\n"
        "bodies: {b: {material: m, shape: {union: {shapes: [{mesh: {file: cube.ply, scale: 1}, translate: [1, 0, 0]}, "
        "{sphere: {radius: 0.1}, translate: [2, 0, 0]}]}}}}"));
    const auto& colour = frame.surfels.get<Vec3f>("Cd");
    const auto& rest = frame.surfels.get<Vec3f>("rest");
    for (std::size_t i = 0; i < colour.size(); ++i)
        EXPECT_EQ(colour[i].minCoeff() < 0, rest[i].x() > 1.5f);  // the ball has none
}

TEST_F(VertexColours, AreNotThereWithoutAColouredMesh) {
    const Frame frame =
        first_frame(parse("materials: {m: {}}\nbodies: {b: {material: m, shape: {sphere: {radius: 0.1}}}}"));
    EXPECT_EQ(frame.surfels.find("Cd"), nullptr);
}

TEST_F(VertexColours, OfAnObstacleAreInItsMesh) {
    const scene::Scene scene = parse(
        "world: {boundaries: {a: {shape: {mesh: {file: cube.ply, scale: 1}}}, b: {shape: {union: {shapes: [{mesh: "
        "{file: "
        "cube.ply, scale: 1}}, {sphere: {radius: 0.05}, translate: [0, 0, 0.3]}]}}}}}\n"
        "materials: {m: {}}\nbodies: {d: {material: m, shape: {sphere: {radius: 0.1}, translate: [1, 0, 0]}}}");
    for (const scene::Boundary& b : scene.world.boundaries) {
        const TriangleMesh mesh = *boundary_mesh(scene, b);
        ASSERT_EQ(mesh.colours.size(), mesh.vertices.size()) << b.name;
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
            if (mesh.vertices[v].z() > 0.2f) {
                EXPECT_EQ(mesh.colours[v], Vec3f(1, 1, 1));
                continue;
            }
            // An edge is rounded by a cell of the extraction, 0.2 % of the longest edge.
            EXPECT_NEAR(mesh.colours[v].x(), 0.5 - 5 * double(mesh.vertices[v].x()), 0.02) << b.name;
        }
    }
}

TEST_F(VertexColours, ThatALookDoesNotShowAreTold) {
    const scene::Scene scene = parse(
        "materials: {m: {youngs_modulus: 1e5}}\n"
        "bodies: {b: {material: m, shape: {mesh: {file: cube.ply, scale: 1}}}}\n"
        "look: {appearances: {m: {colour: [1, 0, 0]}}}");
    testing::internal::CaptureStderr();
    coloured_shapes(scene);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("look.appearances.m does not show"), std::string::npos);
}

}  // namespace
}  // namespace thixo
