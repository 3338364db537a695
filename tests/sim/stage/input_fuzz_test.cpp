// Meshes, point sets and scenes changed by chance, with a fixed seed: each is refused, or set up and stepped on with.
// Nothing else happens, and it takes five seconds at most.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/base/math.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/geometry/mesh_io.h"
#include "sim/stage/estimate.h"
#include "tests/pipeline/contract/mutated.h"
#include "tests/pipeline/driver/temporary_folder.h"
#include "tests/sim/fixture.h"

namespace thixo {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSeed = 20260101;
constexpr double kLongest = 5;  // [s of processor time]
/// What costs time by right is left out: a scene may ask for any number of particles.
constexpr double kMostParticles = 3000, kMostSurfels = 20'000;
/// So short that sub-steps stay few, however light and stiff or thick the matter is. Rubber of a gram in a cubic metre
/// needs four hundred of them even so.
constexpr double kStep = 1e-6;  // s

/// A ball of few corners, so that a change is likely to matter: two poles, and rings between them.
TriangleMesh ball() {
    constexpr Index kRings = 4, kCorners = 7;
    constexpr float kRadius = 0.04f;
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, kRadius}, {0, 0, -kRadius}};
    const auto at = [](Index ring, Index corner) { return 2 + ring * kCorners + corner % kCorners; };
    for (Index r = 0; r < kRings; ++r)
        for (Index c = 0; c < kCorners; ++c) {
            const double polar = kPi * (r + 1) / (kRings + 1), around = 2 * kPi * c / kCorners;
            mesh.vertices.push_back(
                kRadius * Vec3d(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar))
                              .cast<float>());
            if (r == 0) mesh.triangles.push_back({0, at(r, c), at(r, c + 1)});
            if (r > 0) mesh.triangles.push_back({at(r - 1, c), at(r, c), at(r, c + 1)});
            if (r > 0) mesh.triangles.push_back({at(r - 1, c), at(r, c + 1), at(r - 1, c + 1)});
            if (r + 1 == kRings) mesh.triangles.push_back({at(r, c), 1, at(r, c + 1)});
        }
    return mesh;
}

std::string obj(const TriangleMesh& mesh) {
    std::string text;
    for (const Vec3f& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
    for (const auto& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    return text;
}

std::string text_stl(const TriangleMesh& mesh) {
    std::string text = "solid ball\n";
    for (const auto& t : mesh.triangles) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const Index v : t)
            text += fmt::format("vertex {} {} {}\n", mesh.vertices[v].x(), mesh.vertices[v].y(), mesh.vertices[v].z());
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid ball\n";
}

std::string point_set() {
    TriangleMesh points = ball();
    for (const Vec3f& v : points.vertices) points.normals.push_back(v.normalized());
    points.triangles.clear();
    return write_ply(points);
}

struct MeshSeed {
    const char* file;
    std::string bytes;
};
std::vector<MeshSeed> mesh_seeds() {
    return {{"mesh.obj", obj(ball())},
            {"mesh.ply", write_ply(ball())},
            {"mesh.stl", text_stl(ball())},
            {"points.ply", point_set()}};
}

/// A mesh as liquid, as rubber with a surface of its own, and as a wall. Whatever its size, a decimetre of it counts.
std::string scene_around(const std::string& file, std::uint64_t use) {
    const std::string mesh = fmt::format("{{mesh: {{file: {}, scale: 1, place: file}}}}", file);
    const std::string cut = fmt::format("{{intersection: [{}, {{box: {{size: [0.1, 0.1, 0.1]}}}}]}}", mesh);
    const std::string head = "frames: {first: 0, last: 1, fps: 500}\nsolver: {spacing: 0.02}\n";
    if (use == 0) return head + "materials: {m: {viscosity: 0.1}}\nbodies: {b: {material: m, shape: " + cut + "}}\n";
    if (use == 1)
        return head + "materials: {m: {youngs_modulus: 1.0e5}}\nbodies: {b: {material: m, surfels: 200, shape: " + cut +
               "}}\n";
    return head + "materials: {m: {}}\nbodies: {b: {material: m, shape: {box: {size: [0.08, 0.08, 0.08]}}}}\n" +
           "world: {boundaries: {wall: {shape: " + cut + "}}}\n";
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

enum class Outcome { refused, too_large, done };

/// Estimates, sets up and makes a step. Any Error is one of those that end a program with a documented exit code.
Outcome try_scene(const std::string& text, const fs::path& name) {
    try {
        const scene::Scene scene = scene::parse_scene(text, name.string());
        scene::scene_warnings(scene);
        const Size size = estimate_run(scene).size;
        if (!(size.particles <= kMostParticles && size.surfels <= kMostSurfels)) return Outcome::too_large;
        Simulation simulation = make_simulation(scene);
        fixture::steps(simulation, 1, kStep);
        return Outcome::done;
    } catch (const Error&) {
        return Outcome::refused;
    }
}

/// Outcomes by their number; a round that takes too long is a failure.
class Rounds {
  public:
    void add(std::uint64_t round, const std::string& text, const fs::path& name) {
        const double begun = processor_seconds();
        ++counts_[static_cast<std::size_t>(try_scene(text, name))];
        EXPECT_LT(processor_seconds() - begun, kLongest) << "round " << round << "\n" << text;
    }
    std::uint64_t operator[](Outcome outcome) const { return counts_[static_cast<std::size_t>(outcome)]; }

  private:
    std::array<std::uint64_t, 3> counts_{};
};

TEST(InputFuzz, AChangedMeshIsRefusedOrSimulated) {
    const TemporaryFolder folder;
    const std::vector<MeshSeed> seeds = mesh_seeds();
    for (const MeshSeed& seed : seeds)
        for (const std::uint64_t use : {0, 1, 2}) {
            std::ofstream(folder.path / seed.file, std::ios::binary) << seed.bytes;
            EXPECT_EQ(try_scene(scene_around(seed.file, use), folder.path / "scene.yaml"), Outcome::done)
                << seed.file << " as " << use;
        }
    const std::uint64_t rounds = test::fuzz_rounds(120);
    Rounds outcomes;
    for (std::uint64_t k = 0; k < rounds; ++k) {
        const MeshSeed& seed = seeds[k % seeds.size()];
        std::ofstream(folder.path / seed.file, std::ios::binary) << test::mutated(seed.bytes, kSeed, k);
        outcomes.add(k, scene_around(seed.file, k / seeds.size() % 3), folder.path / "scene.yaml");
    }
    // The changes are not always fatal, and not always without effect. Or the test would test little.
    EXPECT_GT(outcomes[Outcome::done], rounds / 10);
    EXPECT_GT(outcomes[Outcome::refused], rounds / 10);
}

TEST(InputFuzz, AChangedSceneIsRefusedOrSimulated) {
    const fs::path root = THIXO_SOURCE_DIR;
    std::vector<std::string> seeds;
    for (const char* file : {"tests/scenes/tiny.yaml", "tests/scenes/solids.yaml", "tests/faults/melting.yaml",
                             "tests/faults/rubber.yaml", "tests/faults/breaking.yaml", "tests/faults/implicit.yaml"})
        seeds.push_back(text_of(root / file));
    for (const std::string& seed : seeds)
        EXPECT_EQ(try_scene(seed, root / "tests/scenes/fuzz.yaml"), Outcome::done) << seed;
    const std::uint64_t rounds = test::fuzz_rounds(120);
    Rounds outcomes;
    for (std::uint64_t k = 0; k < rounds; ++k)
        outcomes.add(
            k,
            (k / seeds.size() % 4 == 0 ? test::mutated : test::with_other_numbers)(seeds[k % seeds.size()], kSeed, k),
            root / "tests/scenes/fuzz.yaml");
    EXPECT_GT(outcomes[Outcome::done], rounds / 10);
    EXPECT_GT(outcomes[Outcome::refused], rounds / 10);
}

}  // namespace
}  // namespace thixo
