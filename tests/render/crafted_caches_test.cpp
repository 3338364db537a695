// Caches with right checksums that no Thixo wrote: each is rendered or refused, and nothing else happens.
#include <gtest/gtest.h>

#include <array>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/info.h"
#include "pipeline/contract/scene_hash.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/vdb_points.h"
#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/tessellate.h"
#include "render/stage.h"
#include "tests/pipeline/contract/cache_fixture.h"
#include "tests/pipeline/contract/mutated.h"
#include "tests/render/surfel_shapes.h"

namespace thixo::render {
namespace {

namespace fs = std::filesystem;

constexpr double kLongest = 5;  // [s of processor time]

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

const char* const kScene = R"(
scene: {name: drop}
frames: {first: 1, last: 1}
world:
  boundaries:
    table: {shape: {plane: {normal: [0, 0, 1], offset: 0}}}
materials:
  water: {}
bodies:
  drop: {material: water, shape: {sphere: {radius: 0.1}, translate: [0, 0, 0.2]}}
look:
  camera: {position: [0, -1, 0.4], look_at: [0, 0, 0.15], fov: 40}
  lights: {sky: {type: sky}}
  appearances:
    water: {type: dielectric, ior: 1.33}
    table: {type: diffuse, checker: 0.1}
  output: {width: 16, height: 9, samples: 1}
)";

/// A cache of one frame: a ball of surfels of two sheets above a table, and a few particles.
void make_cache(const fs::path& out, const std::string& mesh) {
    const scene::Scene scene = scene::parse_scene(kScene, "drop.yaml");
    CacheWriter writer =
        CacheWriter::create(out, {scene.name, scene::print_cached_scene(scene), scene::simulation_hash(scene)});
    Frame frame;
    frame.number = 1;
    frame.spacing = 0.02;
    frame.bodies = {{0, -1, "drop", "water"}};
    frame.particles = test::sample_points(50, 1);
    const SurfelCloud ball = shapes::sphere(120, 0.1f, {0, 0, 0.2f});
    const std::size_t n = ball.size();
    std::vector<std::int32_t> sheet(n);
    for (std::size_t i = 0; i < n; ++i) sheet[i] = ball.position[i].z() > 0.2f;
    frame.surfels.count = n;
    frame.surfels.add("P", ball.position);
    frame.surfels.add("t1", ball.axis1);
    frame.surfels.add("t2", ball.axis2);
    frame.surfels.add("body", std::vector<std::int32_t>(n, 0));
    frame.surfels.add("sheet", sheet);
    FrameObstacle table;
    table.name = table.look = "table";
    table.asset = writer.add_asset(mesh);
    frame.obstacles.push_back(table);
    writer.write_frame(frame);
    writer.finish();
}

/// Changes one file of a cache, and seals it and the manifest.
class Crafter {
  public:
    explicit Crafter(const fs::path& out) : out_(out) { start_again(); }

    /// What was changed in this round. Half of the changes leave files that are well formed, so that they reach the
    /// renderer.
    std::string craft(std::uint64_t round) {
        start_again();
        ManifestFrame& frame = manifest_.frames[0];
        switch (random_bits(kSeed, round, 1, 99) % 10) {
            case 0: {
                const fs::path file = out_ / "cache" / kManifestName;
                put(file, test::sealed_manifest(test::mutated(read_whole(file), kSeed, round)));
                return kManifestName;
            }
            case 1:
                fs::remove_all(out_);
                make_cache(out_, test::mutated(mesh_, kSeed, round));
                return "an asset";
            case 2:
                return put_listed(frame.facts_file, test::mutated(bytes_of(frame.facts_file), kSeed, round));
            case 3:
                return put_listed(frame.particle_file, mutated_points(frame.particle_file, round));
            case 4:
                return put_listed(frame.surfel_file, mutated_points(frame.surfel_file, round));
            case 5:
            case 6:
                return put_listed(frame.facts_file, test::with_other_numbers(bytes_of(frame.facts_file), kSeed, round));
            case 7:
                manifest_.scene_text = test::with_other_numbers(manifest_.scene_text, kSeed, round);
                put(out_ / "cache" / kManifestName, print_manifest(manifest_));
                return "the scene";
            default:
                return put_listed(frame.surfel_file, other_values(frame.surfel_file, round));
        }
    }

  private:
    static constexpr std::uint64_t kSeed = 20260101;
    static constexpr double kVoxel = 0.03125;

    std::string bytes_of(const CacheFile& file) const { return whole_.at("cache/" + file.name); }
    std::string mutated_points(const CacheFile& file, std::uint64_t round) const {
        return test::sealed_points(test::mutated(bytes_of(file), kSeed, round));
    }
    /// Up to eight values of the points are others, as far as a file can hold them.
    std::string other_values(const CacheFile& file, std::uint64_t round) const {
        constexpr std::array<float, 8> kFloats{0, -0.0f, 1, -0.1f, 1e-30f, 1e4f, 1e30f, -1e30f};
        constexpr std::array<std::int32_t, 5> kInts{0, 1, -1, 7, std::numeric_limits<std::int32_t>::max()};
        PointSet points = decode_points(bytes_of(file), file.name);
        for (std::uint64_t k = 0; k < 1 + round % 8; ++k) {
            const auto pick = [&](std::uint64_t use, std::size_t n) {
                return static_cast<std::size_t>(random_bits(kSeed, round, k, use) % n);
            };
            Attribute& a = points.attributes[pick(100, points.attributes.size())];
            const std::size_t row = pick(101, points.count);
            if (auto* v = std::get_if<std::vector<Vec3f>>(&a.data))
                (*v)[row][Eigen::Index(pick(102, 3))] = kFloats[pick(103, kFloats.size())];
            else if (auto* n = std::get_if<std::vector<std::int32_t>>(&a.data))
                (*n)[row] = kInts[pick(103, kInts.size())];
        }
        try {
            return encode_points(points, "surfels", kVoxel);
        } catch (const Error&) {  // too far for its voxels
            return bytes_of(file);
        }
    }
    std::string put_listed(CacheFile& file, const std::string& bytes) {
        put(out_ / "cache" / file.name, bytes);
        file.size = bytes.size();
        file.hash = hash_hex(bytes);
        put(out_ / "cache" / kManifestName, print_manifest(manifest_));
        return file.name;
    }
    static void put(const fs::path& file, const std::string& bytes) {
        std::ofstream(file, std::ios::binary) << bytes;  // not flushed to the disk: it need not last
    }
    void start_again() {
        if (whole_.empty()) {
            make_cache(out_, mesh_);
            whole_ = test::contents(out_);
            manifest_ = CacheReader(out_).manifest();
        }
        fs::remove_all(out_);
        for (const auto& [name, bytes] : whole_) {
            fs::create_directories((out_ / name).parent_path());
            put(out_ / name, bytes);
        }
        manifest_ = parse_manifest(whole_.at("cache/manifest.json"), "manifest");
    }
    fs::path out_;
    std::string mesh_ = write_ply(tessellate_plane({0, 0, 0}, {0, 0, 1}, 4));
    std::map<std::string, std::string> whole_;
    Manifest manifest_;
};

TEST(CraftedCaches, AreRenderedOrRefused) {
    const test::TemporaryFolder folder;
    Crafter crafter(folder / "out");
    RenderArgs args;
    args.out = (folder / "out").string();
    args.quiet = true;
    // What costs time by right is kept small, whatever the crafted look says.
    args.set = {"look.output.width=16", "look.output.height=9", "look.output.samples=1", "look.output.noise=0"};
    const std::uint64_t rounds = test::fuzz_rounds(300);
    std::uint64_t rendered = 0;
    for (std::uint64_t k = 0; k < rounds; ++k) {
        const std::string name = crafter.craft(k);
        const double begun = processor_seconds();
        try {
            describe(args.out, true);
            CacheReader(args.out).load_frame(1);
            run_stage(args);
            ++rendered;
        } catch (const Error&) {
        }
        EXPECT_LT(processor_seconds() - begun, kLongest) << "round " << k << ", " << name;
    }
    EXPECT_GT(rendered, rounds / 5);
    EXPECT_LT(rendered, rounds);
}

}  // namespace
}  // namespace thixo::render
