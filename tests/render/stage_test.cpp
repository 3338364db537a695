// The stage: from a cache to pictures, each once, and the same whichever way they are asked for.
#include "render/stage.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <thread>

#include "pipeline/base/error.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/cache.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/look_images.h"
#include "pipeline/contract/scene_hash.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/geometry/mesh_io.h"
#include "pipeline/geometry/tessellate.h"
#include "tests/render/surfel_shapes.h"

namespace thixo::render {
namespace {

namespace fs = std::filesystem;

const char* const kScene = R"(
scene: {name: drop}
frames: {first: 1, last: 4}
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
  output: {width: 32, height: 18, samples: 2}
)";

class RenderStage : public testing::Test {
  protected:
    RenderStage() {
        std::string name = (fs::temp_directory_path() / "thixo_render_stage_XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
    }
    ~RenderStage() override { fs::remove_all(folder_); }

    std::string out(const std::string& name) const { return (folder_ / name).string(); }

    static CacheWriter writer(const std::string& out) {
        const scene::Scene scene = scene::parse_scene(kScene, "drop.yaml");
        return CacheWriter::create(out, {scene.name, scene::print_scene(scene), scene::simulation_hash(scene)});
    }

    static void add_frame(CacheWriter& writer, int number, const Vec3d& origin = {0, 0, 0},
                          const std::optional<Vec3f>& vertices = std::nullopt) {
        Frame frame;
        frame.number = number;
        frame.time = number / 24.0;
        frame.spacing = 0.02;
        frame.bodies = {{0, -1, "drop", "water"}};
        SurfelCloud ball = shapes::sphere(200, 0.1f, {0, 0, 0.2f - 0.01f * float(number)});
        const std::size_t n = ball.size();
        frame.surfels.count = n;
        frame.surfels.origin = origin;
        frame.surfels.add("P", ball.position);
        frame.surfels.add("t1", ball.axis1);
        frame.surfels.add("t2", ball.axis2);
        frame.surfels.add("body", std::vector<std::int32_t>(n, 0));
        if (vertices) frame.surfels.add("Cd", std::vector<Vec3f>(n, *vertices));
        FrameObstacle table;
        table.name = table.look = "table";
        TriangleMesh mesh = tessellate_plane({0, 0, 0}, {0, 0, 1}, 4);
        if (vertices && vertices->minCoeff() >= 0) mesh.colours.assign(mesh.vertices.size(), *vertices);
        table.asset = writer.add_asset(write_ply(mesh));
        for (const int k : {0, 1, 2}) table.transform[static_cast<std::size_t>(4 * k + 3)] = origin[k];
        frame.obstacles.push_back(table);
        writer.write_frame(frame);
    }

    void make_cache(const std::string& out, int frames = 4) {
        CacheWriter w = writer(out);
        for (int k = 1; k <= frames; ++k) add_frame(w, k);
        w.finish();
    }

    static RenderArgs args(const std::string& out, const std::string& frames = "") {
        RenderArgs a;
        a.out = out;
        a.frames = frames;
        a.quiet = true;
        return a;
    }

    static std::string bytes(const std::string& out, int frame, const char* ending = "exr") {
        return read_whole(fs::path(out) / "frames" / fmt::format("beauty.{:04d}.{}", frame, ending));
    }

    fs::path folder_;
};

TEST_F(RenderStage, TwoHalvesRenderedApartEqualTheWhole) {
    make_cache(out("whole"));
    fs::copy(out("whole"), out("halves"), fs::copy_options::recursive);
    EXPECT_EQ(run_stage(args(out("whole"))), kDone);
    EXPECT_EQ(run_stage(args(out("halves"), "3-4")), kDone);
    EXPECT_EQ(run_stage(args(out("halves"), "1-2")), kDone);
    for (int k = 1; k <= 4; ++k)
        for (const char* ending : {"exr", "png"})
            EXPECT_EQ(bytes(out("whole"), k, ending), bytes(out("halves"), k, ending)) << k << ending;
    EXPECT_NE(bytes(out("whole"), 1), bytes(out("whole"), 2));
}

TEST_F(RenderStage, AShutterThatIsOpenNeedsVelocities) {
    make_cache(out("a"), 1);
    RenderArgs blurred = args(out("a"));
    blurred.set = {"look.camera.shutter_open=-0.25", "look.camera.shutter_close=0.25"};
    EXPECT_THROW(run_stage(blurred), CacheError);
}

TEST_F(RenderStage, PicturesThatAreThereAreKept) {
    make_cache(out("a"));
    run_stage(args(out("a"), "1-2"));
    const fs::path first = fs::path(out("a")) / "frames/beauty.0001.exr";
    const auto old = fs::file_time_type::clock::now() - std::chrono::hours(5);
    fs::last_write_time(first, old);
    run_stage(args(out("a")));
    EXPECT_EQ(fs::last_write_time(first), old);
    EXPECT_TRUE(fs::exists(fs::path(out("a")) / "frames/beauty.0004.png"));
}

TEST_F(RenderStage, ADamagedPictureIsMadeAgain) {
    make_cache(out("a"), 1);
    run_stage(args(out("a")));
    const std::string good = bytes(out("a"), 1);
    fs::resize_file(fs::path(out("a")) / "frames/beauty.0001.exr", good.size() / 2);
    run_stage(args(out("a")));
    EXPECT_EQ(bytes(out("a"), 1), good);
}

TEST_F(RenderStage, RelightingMixesTheFramesThatAreThere) {
    make_cache(out("a"), 1);
    RenderArgs first = args(out("a"));
    first.set = {"look.output.passes.lights=true"};
    run_stage(first);
    RenderArgs brighter = args(out("a"));
    brighter.relight = true;
    brighter.set = {"look.lights.sky.strength=2"};
    run_stage(brighter);
    const Image before = read_exr(fs::path(out("a")) / "frames/beauty.0001.exr"),
                after = read_exr(fs::path(out("a")) / "frames.relit/beauty.0001.exr");
    // Both are stored as halves: each rounds by 2^-11.
    for (std::size_t i = 0; i < before.pixels(); ++i)
        ASSERT_NEAR(after.get("G")[i], 2 * before.get("G")[i], 2e-3f * before.get("G")[i]);
    EXPECT_TRUE(after.get("Z") == before.get("Z"));
    EXPECT_EQ(after.find("variance.G"), nullptr);  // only a mixed picture has none
}

TEST_F(RenderStage, RelightingRendersWhereThereIsNothingToMix) {
    make_cache(out("a"), 1);
    run_stage(args(out("a")));  // without light groups
    RenderArgs brighter = args(out("a"));
    brighter.relight = true;
    brighter.set = {"look.lights.sky.strength=2"};
    run_stage(brighter);
    const Image after = read_exr(fs::path(out("a")) / "frames.relit/beauty.0001.exr");
    EXPECT_NE(after.find("variance.G"), nullptr);
    EXPECT_NE(after.find("light_sky.G"), nullptr);  // it can be mixed itself
}

TEST_F(RenderStage, AnotherLookOverwritesNothingUnasked) {
    make_cache(out("a"), 2);
    run_stage(args(out("a"), "1"));
    const std::string before = bytes(out("a"), 1);
    RenderArgs changed = args(out("a"));
    changed.set = {"look.output.samples=3"};
    try {
        run_stage(changed);
        FAIL() << "overwritten";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("beauty.0001.exr"), std::string::npos);
        EXPECT_NE(std::string(e.what()).find("--restart"), std::string::npos);
    }
    EXPECT_EQ(bytes(out("a"), 1), before);
    EXPECT_FALSE(fs::exists(fs::path(out("a")) / "frames/beauty.0002.exr"));
    changed.restart = true;
    run_stage(changed);
    EXPECT_NE(bytes(out("a"), 1), before);
}

TEST_F(RenderStage, ALookFileHasAFolderOfItsOwn) {
    make_cache(out("a"), 1);
    run_stage(args(out("a")));
    write_whole(folder_ / "night.yaml", "lights: {sky: {strength: 0.05}}\n");
    RenderArgs night = args(out("a"));
    night.look = (folder_ / "night.yaml").string();
    run_stage(night);
    EXPECT_NE(read_whole(fs::path(out("a")) / "frames.night/beauty.0001.exr"), bytes(out("a"), 1));
}

TEST_F(RenderStage, ABodyWearsItsOwnLook) {
    // Of a body's own look and of its material's come the same colours; without it other ones.
    const auto beauty = [&](const std::string& name, const std::string& change, const std::string& to) {
        std::string text = kScene;
        text.replace(text.find(change), change.size(), to);
        const scene::Scene scene = scene::parse_scene(text, "drop.yaml");
        CacheWriter w =
            CacheWriter::create(out(name), {scene.name, scene::print_scene(scene), scene::simulation_hash(scene)});
        add_frame(w, 1);
        w.finish();
        run_stage(args(out(name)));
        const Image image = read_exr(fs::path(out(name)) / "frames/beauty.0001.exr");
        return std::vector{image.get("R"), image.get("G"), image.get("B")};
    };
    const auto own = beauty("own", "material: water,", "material: water, look: table,");
    EXPECT_EQ(own, beauty("material", "water: {}", "water: {look: table}"));
    EXPECT_NE(own, beauty("none", "water: {}", "water: {}"));
}

TEST_F(RenderStage, ColoursOfVerticesAreThoseOfThePicture) {
    // Surfels and an obstacle of one colour look as with that colour in the look. Where a mesh has none, `colour` is taken.
    const auto beauty = [&](const std::string& name, const std::string& look, const std::optional<Vec3f>& vertices) {
        std::string text = kScene;
        const std::string water = "water: {type: dielectric, ior: 1.33}",
                          table = "table: {type: diffuse, checker: 0.1}";
        text.replace(text.find(water), water.size(), "water: {type: diffuse, " + look + "}");
        text.replace(text.find(table), table.size(), "table: {type: diffuse, " + look + "}");
        const scene::Scene scene = scene::parse_scene(text, "drop.yaml");
        CacheWriter w =
            CacheWriter::create(out(name), {scene.name, scene::print_scene(scene), scene::simulation_hash(scene)});
        add_frame(w, 1, {0, 0, 0}, vertices);
        w.finish();
        run_stage(args(out(name)));
        return read_exr(fs::path(out(name)) / "frames/beauty.0001.exr");
    };
    const Vec3f red(1, 0, 0);  // a colour that 8 bits hold
    const Image own = beauty("own", "colour: [1, 0, 0]", std::nullopt);
    const Image shown = beauty("shown", "colour: [0, 1, 0], colour_by: vertices", red);
    const Image without = beauty("without", "colour: [1, 0, 0], colour_by: vertices", std::nullopt);
    const Image none = beauty("none", "colour: [1, 0, 0], colour_by: vertices", Vec3f(-1, -1, -1));
    const Image hidden = beauty("hidden", "colour: [0, 1, 0]", red);
    for (const char* channel : {"R", "G", "B"})
        for (std::size_t i = 0; i < own.pixels(); ++i) {
            const float value = own.get(channel)[i];
            // Weights of blended discs add up to one but for the last bits.
            EXPECT_NEAR(shown.get(channel)[i], value, 1e-3 * (1 + std::abs(value))) << channel << i;
            EXPECT_EQ(without.get(channel)[i], value) << channel << i;
            EXPECT_EQ(none.get(channel)[i], value) << channel << i;
        }
    EXPECT_NE(hidden.get("R"), own.get("R"));
}

TEST_F(RenderStage, APictureFarFromTheOriginIsThatNearIt) {
    const auto picture = [&](const std::string& name, const Vec3d& away) {
        std::string text = kScene;
        const auto replace = [&](const std::string& what, const std::string& by) {
            text.replace(text.find(what), what.size(), by);
        };
        const auto place = [&](double x, double y, double z) {
            return fmt::format("[{}, {}, {}]", away.x() + x, away.y() + y, away.z() + z);
        };
        replace("position: [0, -1, 0.4], look_at: [0, 0, 0.15]",
                fmt::format("position: {}, look_at: {}", place(0, -1, 0.4), place(0, 0, 0.15)));
        replace("lights: {",
                fmt::format("lights: {{lamp: {{type: area, position: {}, size: [0.5, 0.5]}}, ", place(0, 0, 1)));
        replace("samples: 2", "samples: 2, passes: {position: true}");
        const scene::Scene scene = scene::parse_scene(text, "drop.yaml");
        CacheWriter w =
            CacheWriter::create(out(name), {scene.name, scene::print_scene(scene), scene::simulation_hash(scene)});
        add_frame(w, 1, away);
        w.finish();
        run_stage(args(out(name)));
        return read_exr(fs::path(out(name)) / "frames/beauty.0001.exr");
    };
    const Vec3d away(1e6, -3e4, 200);
    const Image near = picture("near", {0, 0, 0}), far = picture("far", away);
    // Camera and lamp are rounded to 1e-10 m. Where that turns a float's last bit, a ray moves by 1e-7 of a picture.
    for (const char* channel : {"R", "G", "B", "Z"})
        for (std::size_t i = 0; i < near.pixels(); ++i)
            EXPECT_NEAR(near.get(channel)[i], far.get(channel)[i], 1e-3 * std::abs(near.get(channel)[i]))
                << channel << i;
    const std::size_t below = 17 * 32 + 16;  // the table, before the drop
    for (const int k : {0, 1, 2}) {
        const std::string channel = std::string("P.") + "XYZ"[k];
        // Of a float of this size half the last bit is 0.03 m.
        EXPECT_NEAR(double(far.get(channel)[below]), away[k] + double(near.get(channel)[below]), 0.04) << channel;
    }
}

TEST_F(RenderStage, AMissingFrameIsNamedAfterTheOthersAreRendered) {
    make_cache(out("a"), 2);
    try {
        run_stage(args(out("a"), "1-5"));
        FAIL() << "no complaint";
    } catch (const CacheError& e) {
        EXPECT_NE(std::string(e.what()).find("frame 3"), std::string::npos);
    }
    EXPECT_FALSE(bytes(out("a"), 2).empty());
}

TEST_F(RenderStage, AFollowerRendersFramesAsTheyCome) {
    CacheWriter w = writer(out("a"));
    std::thread simulation([&] {
        for (int k = 1; k <= 4; ++k) {
            std::this_thread::sleep_for(std::chrono::milliseconds(30));
            add_frame(w, k);
        }
        w.finish();
    });
    RenderArgs follow = args(out("a"));
    follow.follow = true;
    EXPECT_EQ(run_stage(follow), kDone);
    simulation.join();
    make_cache(out("b"));
    run_stage(args(out("b")));
    for (int k = 1; k <= 4; ++k) EXPECT_EQ(bytes(out("a"), k), bytes(out("b"), k));
}

TEST_F(RenderStage, ThreadsAndPlacesLeaveNoTrace) {
    make_cache(out("a"), 1);
    fs::copy(out("a"), out("elsewhere"), fs::copy_options::recursive);
    RenderArgs one = args(out("a")), three = args(out("elsewhere"));
    one.threads = 1;
    three.threads = 3;
    run_stage(one);
    run_stage(three);
    EXPECT_EQ(bytes(out("a"), 1), bytes(out("elsewhere"), 1));
}

constexpr const char* kPictured = R"(
scene: {name: drop}
frames: {first: 1, last: 1}
world: {boundaries: {table: {shape: {plane: {normal: [0, 0, 1], offset: 0}}}}}
materials: {water: {}}
bodies: {drop: {material: water, shape: {sphere: {radius: 0.1}, translate: [0, 0, 0.2]}}}
look:
  camera: {position: [0, -1, 0.4], look_at: [0, 0, 0.15], fov: 40}
  lights: {room: {type: environment, file: room.exr}}
  appearances:
    water: {type: conductor, roughness: 0.1}
    table: {image: {file: wood.png, size: [0.2, 0.2]}}
  output: {width: 32, height: 18, samples: 2}
)";

TEST_F(RenderStage, ACacheWithImagesThatWasMovedGivesTheSameBytesWithoutTheFiles) {
    Image room(16, 8);
    for (const char* c : {"R", "G", "B"}) {
        std::vector<float>& values = room.add(c, false);
        for (std::size_t k = 0; k < values.size(); ++k) values[k] = k == 37 ? 40.0f : 0.3f + 0.01f * float(k % 16);
    }
    write_exr(folder_ / "room.exr", room);
    write_png(folder_ / "wood.png", {2, 2, 3, {200, 0, 0, 0, 200, 0, 0, 0, 200, 200, 200, 0}});
    write_whole(folder_ / "scene.yaml", kPictured);
    const scene::Scene scene = scene::load_scene((folder_ / "scene.yaml").string());
    {
        CacheWriter w =
            CacheWriter::create(out("a"), {scene.name, scene::print_scene(scene), scene::simulation_hash(scene)});
        scene::store_images(scene.look, w);
        add_frame(w, 1);
        w.finish();
    }
    fs::copy(out("a"), out("b"), fs::copy_options::recursive);
    fs::copy(out("a"), out("c"), fs::copy_options::recursive);
    RenderArgs by_scene = args(out("a"));
    by_scene.scene = (folder_ / "scene.yaml").string();
    run_stage(by_scene);
    for (const char* name : {"room.exr", "wood.png", "scene.yaml"}) fs::remove(folder_ / name);
    run_stage(args(out("b")));
    EXPECT_EQ(bytes(out("a"), 1), bytes(out("b"), 1));
    // A cache whose asset is damaged or gone says so.
    const CacheReader reader(out("c"));
    for (const CacheFile& asset : reader.manifest().assets)
        if (asset.name.ends_with(".exr")) fs::resize_file(reader.folder() / asset.name, asset.size - 3);
    EXPECT_THROW(run_stage(args(out("c"))), CacheError);
}

TEST_F(RenderStage, ACropIsThatPartOfTheWholePictureAndFramesMayGoElsewhere) {
    make_cache(out("a"), 1);
    EXPECT_EQ(run_stage(args(out("a"))), kDone);
    RenderArgs part = args(out("a"));
    part.pictures = out("elsewhere");
    part.crop = "5,3,20,10";
    EXPECT_EQ(run_stage(part), kDone);
    const Image whole = decode_exr(bytes(out("a"), 1), "whole"), crop = decode_exr(bytes(out("elsewhere"), 1), "crop");
    ASSERT_EQ(crop.width, 20);
    ASSERT_EQ(crop.height, 10);
    EXPECT_EQ(crop.attributes.at("thixo.crop"), "5,3,20,10 of 32 x 18");
    for (const ImageChannel& c : crop.channels)
        for (std::size_t y = 0; y < 10; ++y)
            for (std::size_t x = 0; x < 20; ++x)
                ASSERT_EQ(c.values[y * 20 + x], whole.get(c.name)[(y + 3) * 32 + x + 5]) << c.name;
    part.pictures = "";
    EXPECT_THROW(run_stage(part), InputError) << "another look than that of the frames there";
    part.pictures = out("elsewhere");
    part.crop = "13,0,20,10";
    EXPECT_THROW(run_stage(part), InputError) << "beyond the picture";
}

TEST_F(RenderStage, ABlackBodyNeedsTemperatures) {
    make_cache(out("a"), 1);  // its surfels have none
    for (const std::string who : {"water", "table"}) {
        write_whole(folder_ / "lava.yaml",
                    fmt::format("appearances: {{{}: {{type: diffuse, checker: 0, glow: {{strength: 1, black_body: "
                                "1000}}}}}}\n",
                                who));
        RenderArgs lava = args(out("a"));
        lava.look = (folder_ / "lava.yaml").string();
        try {
            run_stage(lava);
            FAIL() << "accepted";
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find("look.appearances." + who + ".glow.black_body: "), std::string::npos)
                << e.what();
            EXPECT_NE(std::string(e.what()).find("has no temperatures"), std::string::npos) << e.what();
        }
    }
}

TEST_F(RenderStage, RelightingDimsWhatGlows) {
    make_cache(out("a"), 1);
    RenderArgs first = args(out("a"));
    first.set = {"look.output.passes.lights=true", "look.appearances.table.glow.strength=0.5"};
    run_stage(first);
    RenderArgs dimmer = args(out("a"));
    dimmer.relight = true;
    dimmer.set = {"look.appearances.table.glow.strength=0.25"};
    run_stage(dimmer);
    const Image before = read_exr(fs::path(out("a")) / "frames/beauty.0001.exr"),
                after = read_exr(fs::path(out("a")) / "frames.relit/beauty.0001.exr");
    EXPECT_EQ(after.find("variance.G"), nullptr);  // only a mixed picture has none
    for (std::size_t i = 0; i < before.pixels(); ++i)
        ASSERT_NEAR(after.get("G")[i], before.get("G")[i] - before.get("light_glow.G")[i] / 2,
                    2e-3f * before.get("G")[i]);
}

TEST_F(RenderStage, TextureCoordinatesThatAMeshDoesNotHaveAreAnError) {
    make_cache(out("a"), 1);
    write_png(folder_ / "wood.png", {1, 1, 3, {200, 0, 0}});
    for (const char* who : {"table: {checker: 0, ", "water: {type: diffuse, "}) {
        write_whole(folder_ / "wood.yaml",
                    fmt::format("appearances: {{{}image: {{file: wood.png, mapping: uv}}}}}}\n", who));
        RenderArgs wood = args(out("a"));
        wood.look = (folder_ / "wood.yaml").string();
        try {
            run_stage(wood);
            FAIL() << "accepted";
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find("has no texture coordinates"), std::string::npos) << e.what();
        }
    }
}

}  // namespace
}  // namespace thixo::render
