// Images that a look names: bound by content, stored with the cache, refused in one clear line where they are of no
// use.
#include "pipeline/contract/look_images.h"

#include <gtest/gtest.h>

#include <ctime>

#include "pipeline/contract/image.h"
#include "pipeline/contract/scene_hash.h"
#include "pipeline/contract/scene_io.h"
#include "tests/pipeline/contract/cache_fixture.h"
#include "tests/pipeline/contract/mutated.h"

namespace thixo::scene {
namespace {

using test::TemporaryFolder;

Image grey(int width, int height, float value) {
    Image image(width, height);
    for (const char* name : {"R", "G", "B"}) image.add(name, false).assign(image.pixels(), value);
    return image;
}

std::string sky_bytes(float value = 0.5f) { return encode_exr(grey(8, 4, value)); }
/// A Radiance HDR of flat scan lines, one grey all over: 192.5 2^(exponent - 136).
std::string hdr_bytes(int width, int height, int exponent = 130) {
    std::string bytes = fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", height, width);
    for (int k = 0; k < width * height; ++k) bytes += {'\xc0', '\xc0', '\xc0', static_cast<char>(exponent)};
    return bytes;
}

/// A grey JPEG of 8 x 8 pixels.
std::string jpeg_bytes() {
    const std::filesystem::path file =
        std::filesystem::path(THIXO_SOURCE_DIR) / "tests/pipeline/contract/images/grey_8x8.jpg";
    return read_whole(file);
}

std::string wood_bytes() { return encode_png({2, 2, 3, {10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120}}); }

constexpr const char* kScene = R"(
materials: {water: {}}
bodies: {drop: {material: water, shape: {sphere: {radius: 0.1}}}}
look:
  lights: {room: {type: environment, file: images/room.exr, rotation: 30, strength: 2}}
  appearances: {water: {image: {file: images/wood.png, size: [0.2, 0.1]}}}
)";

class LookImages : public testing::Test {
  protected:
    LookImages() {
        make_folder(folder_ / "images");
        write("images/room.exr", sky_bytes());
        write("images/wood.png", wood_bytes());
        write("scene.yaml", kScene);
    }
    void write(const char* name, const std::string& bytes) { write_whole(folder_ / name, bytes); }
    Scene load(const std::vector<std::string>& set = {}) { return load_scene((folder_ / "scene.yaml").string(), set); }

    std::string refusal(const std::vector<std::string>& set = {}) {
        try {
            load(set);
        } catch (const InputError& e) {
            EXPECT_EQ(e.code(), kBadInput);
            return e.what();
        }
        return "accepted";
    }

    TemporaryFolder folder_;
};

TEST_F(LookImages, AreKnownByTheirContent) {
    const Scene s = load();
    EXPECT_EQ(s.look.lights[0].content, hash_hex(sky_bytes()));
    EXPECT_EQ(s.look.appearances[0].image.content, hash_hex(wood_bytes()));
    EXPECT_EQ(s.look.lights[0].file, (folder_ / "images/room.exr").string());  // relative to the scene
    write("elsewhere.exr", sky_bytes());
    write("other.exr", sky_bytes(0.25f));
    const auto with = [&](const char* file) { return load({"look.lights.room.file=" + (folder_ / file).string()}); };
    EXPECT_EQ(look_hash(with("elsewhere.exr").look), look_hash(s.look));
    EXPECT_NE(look_hash(with("other.exr").look), look_hash(s.look));
    EXPECT_EQ(simulation_hash(with("other.exr")), simulation_hash(s));  // a changed light never simulates again
}

TEST_F(LookImages, ThatAreOfNoUseAreRefused) {
    const std::string good = sky_bytes();
    Image no_blue = grey(8, 4, 1);
    no_blue.channels.pop_back();
    Image not_a_number = grey(8, 4, 1), negative = grey(8, 4, 1), endless = grey(8, 4, 1);
    not_a_number.channels[1].values[13] = std::nanf("");
    negative.channels[2].values[31] = -0.001f;
    endless.channels[0].values[0] = std::numeric_limits<float>::infinity();
    std::string flipped = good;
    flipped[flipped.size() / 2] = char(flipped[flipped.size() / 2] ^ 1);
    const std::pair<std::string, const char*> bad[] = {
        {good.substr(0, good.size() - 20), "damaged"},
        {good.substr(0, 100), "damaged"},
        {flipped, "damaged"},
        {"", "is not an EXR or HDR"},
        {"v 0 0 0\n", "is not an EXR or HDR"},
        {wood_bytes(), "is not an EXR or HDR"},
        {jpeg_bytes(), "is not an EXR or HDR"},
        {hdr_bytes(7, 4), "twice as wide as high"},
        {hdr_bytes(8, 4).substr(0, 100), "ends early"},
        {encode_exr(grey(8, 8, 1)), "twice as wide as high"},
        {encode_exr(no_blue), "no channel B"},
        {encode_exr(not_a_number), "G = nan at column 5 of row 1"},
        {encode_exr(negative), "B = -0.001 at column 7 of row 3"},
        {encode_exr(endless), "R = inf at column 0 of row 0"},
    };
    for (const auto& [bytes, reason] : bad) {
        write("images/room.exr", bytes);
        const std::string told = refusal();
        EXPECT_NE(told.find(reason), std::string::npos) << told;
        EXPECT_NE(told.find("scene.yaml:5:"), std::string::npos) << told;  // the line that names it
        EXPECT_NE(told.find("room.exr"), std::string::npos) << told;
        EXPECT_NE(told.find("1 error"), std::string::npos) << told;
    }
    std::filesystem::remove(folder_ / "images/room.exr");
    EXPECT_NE(refusal().find("there is no image file"), std::string::npos);
    std::filesystem::create_directory(folder_ / "images/room.exr");
    EXPECT_NE(refusal().find("there is no image file"), std::string::npos);
}

TEST_F(LookImages, OfSurfacesHaveColours) {
    write("images/wood.png", wood_bytes().substr(0, 40));
    EXPECT_NE(refusal().find("damaged"), std::string::npos);
    write("images/wood.png", encode_exr(grey(3, 2, 1.5f)));  // by its bytes an EXR
    EXPECT_NE(refusal().find("colours go from 0 to 1"), std::string::npos);
    write("images/wood.png", encode_exr(grey(3, 2, 0.5f)));
    EXPECT_EQ(refusal(), "accepted");
    write("images/wood.png", jpeg_bytes());
    EXPECT_EQ(refusal(), "accepted");
    write("images/wood.png", jpeg_bytes().substr(0, 150));
    EXPECT_NE(refusal().find("damaged"), std::string::npos);
    write("images/wood.png", hdr_bytes(8, 4, 128));
    EXPECT_EQ(refusal(), "accepted");
    write("images/wood.png", hdr_bytes(8, 4, 129));
    EXPECT_NE(refusal().find("colours go from 0 to 1"), std::string::npos);
    write("images/wood.png", std::string("GIF89a"));
    EXPECT_NE(refusal().find("is not a PNG, JPEG, EXR or HDR"), std::string::npos);
    std::filesystem::remove(folder_ / "images/wood.png");
    EXPECT_NE(refusal().find("there is no image file"), std::string::npos);
}

TEST_F(LookImages, MappedByUvAreForMeshesAlone) {
    const std::string uv = "look.appearances.water.image.mapping=uv";
    const std::string told = refusal({uv});
    EXPECT_NE(told.find("the body \"drop\", made of surfels, has no texture coordinates"), std::string::npos) << told;
    EXPECT_NE(told.find("1 error"), std::string::npos) << told;
    const auto with = [&](const std::string& blocks) {
        write("scene.yaml", blocks + "look: {appearances: {tiles: {image: {file: images/wood.png, mapping: uv}}}}\n");
        return refusal();
    };
    const std::string vessel = "materials: {water: {}}\nworld: {boundaries: {floor: {look: tiles, shape: ";
    EXPECT_NE(with(vessel + "{plane: {}}}}}\n").find("scene.yaml:3:"), std::string::npos);
    EXPECT_NE(with(vessel + "{plane: {}}}}}\n").find("the boundary \"floor\", no mesh, has no"), std::string::npos);
    EXPECT_EQ(with(vessel + "{plane: {}}, visible: false}}}\n"), "accepted");
    const std::string poured = "materials: {water: {look: tiles}}\nemitters: {tap: {material: water}}\n";
    EXPECT_NE(with(poured).find("what the emitter \"tap\" releases has no"), std::string::npos);
    // Whether a mesh has any, its file tells; a named shape or one of a list may be a mesh.
    write("m.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    const std::string shapes = "shapes: {rock: {mesh: {file: m.obj, scale: 1}}}\n";
    EXPECT_EQ(with(shapes + vessel + "{named: rock}}}}\n"), "accepted");
    EXPECT_EQ(with(shapes + vessel + "{union: {shapes: [{named: rock}, {sphere: {radius: 1}}]}}}}}\n"), "accepted");
}

TEST_F(LookImages, KeysThatDoNotFitTogetherAreTold) {
    EXPECT_NE(refusal({"look.appearances.water.checker=0.1"}).find("takes the place of"), std::string::npos);
    EXPECT_NE(refusal({"look.appearances.water.type=dielectric"}).find("absorption"), std::string::npos);
    EXPECT_NE(refusal({"look.lights.room.file=\"\""}).find("needs a \"file\""), std::string::npos);
    EXPECT_NE(refusal({"look.lights.room.content=0123"}).find("has changed: its content is"), std::string::npos);
}

TEST_F(LookImages, GoIntoTheCacheAndOutliveTheirFiles) {
    const Scene scene = load();
    const std::string text = print_cached_scene(scene);
    {
        CacheWriter cache = CacheWriter::create(folder_ / "out", {scene.name, text, simulation_hash(scene)});
        store_images(scene.look, cache);
        store_images(scene.look, cache);  // each once
        cache.finish();
    }
    std::filesystem::remove_all(folder_ / "images");
    std::filesystem::rename(folder_ / "out", folder_ / "moved");
    const CacheReader reader(folder_ / "moved");
    EXPECT_EQ(reader.manifest().assets.size(), 2u);
    EXPECT_EQ(reader.manifest().format, 2);
    const Scene cached = parse_cached_scene(reader.scene_text(), "manifest.json");
    EXPECT_EQ(look_hash(cached.look), look_hash(scene.look));
    std::vector<std::string> bytes;
    for_each_image(cached.look, [&](const std::string&, ImageUse, const std::string& file, const std::string& content) {
        bytes.push_back(image_bytes(file, content, &reader));
        EXPECT_THROW(image_bytes(file, content, nullptr), CacheError);
    });
    EXPECT_EQ(bytes, (std::vector<std::string>{sky_bytes(), wood_bytes()}));
}

TEST_F(LookImages, OfACachesLookAreNotLookedAtButThoseOfALookFileAre) {
    const Scene scene = load();
    const std::string text = print_scene(scene);
    std::filesystem::remove_all(folder_ / "images");
    const Scene cached = parse_scene(text, "manifest.json", {}, Files::ignore);
    write("night.yaml", "lights: {room: {strength: 0.1}}\n");
    const Look dim = overlay_look(cached.look, (folder_ / "night.yaml").string());
    EXPECT_EQ(dim.lights[0].content, scene.look.lights[0].content);
    make_folder(folder_ / "looks");
    write("looks/stars.exr", sky_bytes(0.01f));
    write("looks/stars.yaml", "lights: {room: {file: stars.exr}}\n");  // beside the look file
    const Look stars = overlay_look(cached.look, (folder_ / "looks/stars.yaml").string());
    EXPECT_EQ(stars.lights[0].content, hash_hex(sky_bytes(0.01f)));
    EXPECT_EQ(stars.appearances[0].image.content, scene.look.appearances[0].image.content);
    write("looks/gone.yaml", "lights: {room: {file: gone.exr}}\n");
    EXPECT_THROW(overlay_look(cached.look, (folder_ / "looks/gone.yaml").string()), InputError);
    // An override of a cache's scene names a file of today.
    const Scene set = parse_scene(text, "manifest.json",
                                  {"look.lights.room.file=" + (folder_ / "looks/stars.exr").string()}, Files::ignore);
    EXPECT_EQ(set.look.lights[0].content, hash_hex(sky_bytes(0.01f)));
}

TEST_F(LookImages, AndMeshesAreNamedByContentAloneInACache) {
    write("ball.ply", "ply, or so it seems");
    write("scene.yaml",
          std::string(kScene) + "world: {boundaries: {ball: {shape: {mesh: {file: ball.ply, scale: 1}}}}}\n");
    const std::string text = print_cached_scene(load());
    EXPECT_EQ(text.find(folder_.path().string()), std::string::npos) << text;
    EXPECT_EQ(text.find("room.exr"), std::string::npos) << text;
    EXPECT_EQ(simulation_hash(parse_cached_scene(text, "manifest.json")), simulation_hash(load()));
    // The same scene by another way to its file.
    const std::filesystem::path here = std::filesystem::current_path();
    std::filesystem::current_path(folder_.path());
    const std::string relative = print_cached_scene(load_scene("scene.yaml"));
    std::filesystem::current_path(here);
    EXPECT_EQ(relative, text);
}

TEST_F(LookImages, OfACacheAreReadFromItAndNowhereElse) {
    const Scene scene = load();
    for (const std::string& text : {print_scene(scene), print_cached_scene(scene)}) {  // the former by older programs
        CacheWriter cache = CacheWriter::restart(folder_ / "out", {scene.name, text, simulation_hash(scene)});
        cache.finish();  // without the images, whose files are still there
        const CacheReader reader(folder_ / "out");
        const Scene cached = parse_cached_scene(reader.scene_text(), "manifest.json");
        for_each_image(cached.look, [&](const std::string&, ImageUse, const std::string& file, const std::string& c) {
            EXPECT_THROW(image_bytes(file, c, &reader), CacheError);
        });
    }
}

TEST_F(LookImages, AFileThatChangesBehindOurBackIsNoticed) {
    const Scene scene = load();
    write("images/room.exr", sky_bytes(0.75f));
    EXPECT_THROW(image_bytes(scene.look.lights[0].file, scene.look.lights[0].content, nullptr), InputError);
}

/// Whether a look may use it, in a time that depends on its size.
bool is_usable(const std::string& bytes, ImageUse use) {
    const std::clock_t begun = std::clock();
    bool usable = true;
    try {
        require_usable_image(bytes, "image", use);
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("'image'"), std::string::npos) << e.what();
        usable = false;
    }
    EXPECT_LT(double(std::clock() - begun) / CLOCKS_PER_SEC, 5);
    return usable;
}

TEST(ChangedImages, AreReadOrRefused) {
    Image8 picture{16, 16, 3, {}};
    for (std::uint64_t i = 0; i < 16 * 16 * 3; ++i) picture.values.push_back(std::uint8_t(random_bits(2, i, 0, 0)));
    const std::string png = encode_png(picture);
    std::string exr = sky_bytes();  // under another name for the checksum it is another program's, and carries none
    exr.replace(exr.find("thixo_checksum"), 14, "other_checksum");
    const std::uint64_t rounds = test::fuzz_rounds(1000);
    std::uint64_t usable = 0;
    for (std::uint64_t k = 0; k < rounds; ++k)
        usable += k % 2 ? is_usable(test::mutated(exr, 20260101, k), ImageUse::environment)
                        : is_usable(test::sealed_png(test::mutated(png, 20260101, k)), ImageUse::texture);
    EXPECT_GT(usable, rounds / 50);
    EXPECT_LT(usable, rounds);
}

TEST(ChangedImages, OfOtherProgramsAreReadOrRefused) {
    std::string packed = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 8 +X 16\n";
    for (int line = 0; line < 8; ++line) {
        packed += {2, 2, 0, 16};
        for (int component = 0; component < 4; ++component)  // a run of 10, then 6 as they are
            packed += {'\x8a', '\x80', 6, '\x7e', '\x7f', '\x80', '\x81', '\x82', '\x83'};
    }
    ASSERT_TRUE(is_usable(packed, ImageUse::environment));
    const std::string jpeg = jpeg_bytes();
    const std::uint64_t rounds = test::fuzz_rounds(1000);
    std::uint64_t usable = 0;
    for (std::uint64_t k = 0; k < rounds; ++k)
        usable += k % 2 ? is_usable(test::mutated(packed, 20260102, k), ImageUse::environment)
                        : is_usable(test::mutated(jpeg, 20260102, k), ImageUse::texture);
    EXPECT_GT(usable, rounds / 50);
    EXPECT_LT(usable, rounds);
}

TEST_F(LookImages, OfOtherProgramsGoIntoTheCacheAsTheyAre) {
    write("images/room.exr", hdr_bytes(8, 4));
    write("images/wood.png", jpeg_bytes());
    const Scene scene = load();
    CacheWriter cache =
        CacheWriter::create(folder_ / "out", {scene.name, print_cached_scene(scene), simulation_hash(scene)});
    store_images(scene.look, cache);
    cache.finish();
    const CacheReader reader(folder_ / "out");
    EXPECT_EQ(reader.manifest().format, 4);  // an earlier program refuses it by that number
    EXPECT_TRUE(reader.manifest().lists("assets/" + hash_hex(hdr_bytes(8, 4)) + ".hdr"));
    EXPECT_TRUE(reader.manifest().lists("assets/" + hash_hex(jpeg_bytes()) + ".jpg"));
    for_each_image(scene.look, [&](const std::string&, ImageUse, const std::string& file, const std::string& content) {
        EXPECT_EQ(hash_hex(image_bytes(file, content, &reader)), content);
    });
}

}  // namespace
}  // namespace thixo::scene
