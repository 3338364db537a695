// Defaults that follow from the rest of a scene, and what a look replaces of them.
#include "pipeline/contract/scene_defaults.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/contract/scene_extent.h"
#include "pipeline/contract/scene_io.h"
#include "tests/pipeline/contract/entry.h"

namespace thixo::scene {
namespace {

Scene parsed(const std::string& text) { return parse_scene(text, "defaults.yaml"); }

/// The message of the error that the scene makes.
std::string refusal(const std::string& text) {
    try {
        parsed(text);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

std::vector<std::string> lights_under(const std::string& scene, const std::string& look) {
    // Tests run side by side: each has a file of its own.
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    const std::filesystem::path file = std::filesystem::temp_directory_path() / ("thixo_" + test + "_look.yaml");
    std::ofstream(file) << look;
    std::vector<std::string> names;
    for (const Light& l : overlay_look(parsed(scene).look, file.string()).lights) names.push_back(l.name);
    std::filesystem::remove(file);
    return names;
}

using Names = std::vector<std::string>;

TEST(ALook, ThatTheProgramMakesShowsTheColoursOfMeshes) {
    const auto of = [](const std::string& shape) {
        const Scene scene = parse_scene(
            "shapes: {bust: {mesh: {file: a.ply, scale: 1}}}\nmaterials: {m: {}}\nbodies: {b: {material: m, shape: " +
                shape + "}}\nworld: {boundaries: {w: {shape: " + shape + "}}}\n",
            "colours.yaml", {}, Files::ignore);
        EXPECT_EQ(entry(scene.look.appearances, "m").colour_by, entry(scene.look.appearances, "w").colour_by);
        return entry(scene.look.appearances, "m").colour_by;
    };
    EXPECT_EQ(of("{mesh: {file: a.ply, scale: 1}}"), ColourBy::vertices);
    EXPECT_EQ(of("{union: {shapes: [{sphere: {}}, {mesh: {file: a.ply, scale: 1}}]}}"), ColourBy::vertices);
    EXPECT_EQ(of("{named: bust}"), ColourBy::vertices);
    EXPECT_EQ(of("{sphere: {}}"), ColourBy::none);
}

TEST(Warnings, TellWhatSinglePrecisionDoesNotHold) {
    const auto warned = [](const std::string& away) {
        const Scene scene = parsed(
            "materials: {m: {}}\nsolver: {spacing: 0.01}\nbodies: {a: {material: m, shape: {sphere: {}}}, "
            "b: {material: m, shape: {sphere: {}, translate: [" +
            away + ", 0, 0]}}}\n");
        for (const std::string& w : scene_warnings(scene))
            if (w.find("single precision") != std::string::npos) return w;
        return std::string();
    };
    EXPECT_EQ(warned("2000"), "");
    EXPECT_NE(warned("2700").find("1.35e+05 spacings"), std::string::npos) << warned("2700");
    EXPECT_NE(warned("2700").find("to 0.0078 spacings"), std::string::npos) << warned("2700");
}

TEST(ALook, OfOneLampReplacesTheLightsThatNobodyAskedFor) {
    EXPECT_EQ(lights_under("{}", "lights: {lamp: {type: area}}\n"), (Names{"lamp"}));
    // As a cache carries the scene, all lights are named.
    EXPECT_EQ(lights_under(print_scene(parsed("{}")), "lights: {lamp: {type: area}}\n"), (Names{"lamp"}));
}

TEST(ALook, KnowsDefaultLightsThatStateWhereTheyShine) {
    // As caches of earlier programs do, also of a sky.
    Scene earlier = parsed("{}");
    Light& sky = earlier.look.lights[0];
    ASSERT_EQ(sky.type, LightType::sky);
    sky.direction = Vec3d(0, 0, -1);
    EXPECT_EQ(lights_under(print_scene(earlier), "lights: {lamp: {type: area}}\n"), (Names{"lamp"}));
    for (const std::string& warning : scene_warnings(earlier))
        EXPECT_EQ(warning.find("direction does nothing"), std::string::npos) << warning;
}

TEST(ALook, KeepsTheLightsThatTheSceneNames) {
    const std::string scene = "look: {lights: {sun: {type: sun, strength: 3}}}\n";
    EXPECT_EQ(lights_under(scene, "lights: {lamp: {type: area}}\n"), (Names{"sun", "lamp"}));
}

TEST(ALook, ThatNamesADefaultLightChangesIt) {
    EXPECT_EQ(lights_under("{}", "lights: {sun: {strength: 9}}\n"), (Names{"sun"}));
}

TEST(ALook, WithoutLightsKeepsThem) {
    EXPECT_EQ(lights_under("{}", "camera: {fov: 20}\n"), (Names{"sky", "sun"}));
    EXPECT_EQ(lights_under("{}", "lights:\n"), (Names{"sky", "sun"}));
}

TEST(ALook, SaysThatThereAreNone) {
    EXPECT_EQ(lights_under("{}", "lights: {}\n"), Names());
    EXPECT_EQ(lights_under("look: {lights: {sun: {type: sun}}}\n", "lights: {}\n"), Names());
    const Scene dark = parsed("look: {lights: {}}\n");
    EXPECT_TRUE(dark.look.lights.empty());
    EXPECT_TRUE(parsed(print_scene(dark)).look.lights.empty());
}

TEST(ASolid, ResistsAChangeOfVolumeByE) {
    const Scene s = parsed(
        "materials: {jelly: {youngs_modulus: 1.0e4}, soft: {youngs_modulus: 1.0e4, volume_stiffness: 0}, "
        "water: {}}\n");
    EXPECT_EQ(entry(s.materials, "jelly").elastic.volume_stiffness, 1e4);
    EXPECT_EQ(entry(s.materials, "soft").elastic.volume_stiffness, 0);
    EXPECT_EQ(entry(s.materials, "water").elastic.volume_stiffness, 0);
    EXPECT_EQ(parsed(print_scene(s)).materials[1].elastic.volume_stiffness, 0);
}

bool sticks(const std::string& material, const std::string& boundary = "{shape: {plane: {}}}") {
    return parsed("materials: {m: " + material +
                  ", other: {viscosity: 50}}\nbodies: {b: {material: m, shape: {sphere: {}}}}\n"
                  "world: {boundaries: {floor: " +
                  boundary + "}}\n")
        .world.boundaries[0]
        .no_slip;
}

TEST(AWall, HoldsThickLiquidsUnlessToldOtherwise) {
    EXPECT_TRUE(sticks("{viscosity: 5}"));
    EXPECT_TRUE(sticks("{viscosity: 1}"));
    EXPECT_TRUE(sticks("{youngs_modulus: 1.0e4, melting: {from: 30, to: 40, liquid: {viscosity: 5}}}"));
    EXPECT_FALSE(sticks("{viscosity: 5}", "{shape: {plane: {}}, no_slip: false}"));
}

TEST(AWall, LetsThinLiquidsAndSolidsSlide) {
    EXPECT_FALSE(sticks("{}"));
    EXPECT_FALSE(sticks("{viscosity: 0.5}"));
    EXPECT_FALSE(sticks("{youngs_modulus: 1.0e4, viscosity: 5}"));  // of a solid it damps vibrations
    EXPECT_TRUE(sticks("{viscosity: 0.5}", "{shape: {plane: {}}, no_slip: true}"));
}

std::string tap(const std::string& keys) {
    return "materials: {water: {}}\nemitters: {tap: {material: water, " + keys + "}}\n";
}

TEST(AnEmittersRate, TakesThePlaceOfItsSpeed) {
    const Emitter e = parsed(tap("rate: 0.002")).emitters[0];
    EXPECT_EQ(e.rate, 0.002);
    EXPECT_EQ(e.speed, 0);
    EXPECT_EQ(parsed(tap("radius: 0.1")).emitters[0].speed, 1);
    EXPECT_EQ(print_scene(parsed(print_scene(parsed(tap("rate: 0.002"))))), print_scene(parsed(tap("rate: 0.002"))));
}

TEST(AnEmittersRate, BesideASpeedIsRefused) {
    EXPECT_NE(refusal(tap("rate: 0.002, speed: 1")).find("\"rate\" (0.002) and \"speed\" (1) both say how much"),
              std::string::npos);
    EXPECT_NE(refusal(tap("speed: 0")).find("needs a \"speed\" or a \"rate\" above 0"), std::string::npos);
}

TEST(AnEmittersSwitches, MustAscend) {
    EXPECT_EQ(refusal(tap("switches: [{time: 1, on: false}, {time: 2, on: true}]")), "");
    EXPECT_NE(refusal(tap("switches: [{time: 2, on: false}, {time: 2, on: true}]")).find("not after the one above"),
              std::string::npos);
    EXPECT_NE(refusal(tap("switches: [{time: 2}]")).find("on"), std::string::npos);
}

TEST(ABodysLook, MustBeAnAppearance) {
    const std::string scene =
        "materials: {m: {}}\nlook: {appearances: {red: {}}}\nbodies: {b: {material: m, shape: "
        "{sphere: {}}, look: ";
    EXPECT_EQ(parsed(scene + "red}}\n").bodies[0].look, "red");
    EXPECT_NE(refusal(scene + "rad}}\n").find("there is no appearance \"rad\""), std::string::npos);
}

TEST(ASceneWithoutALook, HasColoursThatDifferAndLiquidsThatLookLikeLiquids) {
    const Scene s = parsed(
        "materials: {a: {}, b: {}, c: {youngs_modulus: 1.0e4}, d: {youngs_modulus: 1.0e4}, honey: "
        "{viscosity: 5}}\nworld: {boundaries: {floor: {shape: {plane: {}}}}}\n");
    const auto look = [&](const char* name) { return entry(s.look.appearances, name); };
    EXPECT_EQ(look("a").type, AppearanceType::dielectric);
    EXPECT_EQ(look("a").ior, 1.33);
    EXPECT_NE(look("a").absorption, look("b").absorption);
    EXPECT_EQ(look("honey").type, AppearanceType::plastic);
    for (const char* one : {"c", "d", "honey"})
        for (const char* other : {"c", "d", "honey", "floor"})
            EXPECT_TRUE(one == std::string(other) || (look(one).colour - look(other).colour).norm() > 0.2);
    EXPECT_LT(look("floor").colour.maxCoeff(), 0.5);
}

/// Whether a point lies in the picture.
bool in_view(const Scene& s, const Vec3d& x) {
    const Camera& c = s.look.camera;
    const Vec3d forward = (c.look_at - c.position).normalized(), right = forward.cross(c.up).normalized(),
                up = right.cross(forward), to = x - c.position;
    const double half = std::tan(c.fov * kPi / 360), high = half * s.look.output.height / s.look.output.width;
    const double depth = to.dot(forward);
    return depth > 0 && std::abs(to.dot(right)) <= half * depth && std::abs(to.dot(up)) <= high * depth;
}

TEST(ASceneWithoutALook, HasACameraThatSeesAllOfIt) {
    for (const double size : {1e-4, 1.0, 300.0})
        for (const double away : {0.0, 1e3})
            for (const char* shape :
                 {"box: {}", "cylinder: {radius: 0.5, height: 1}", "capsule: {from: [0, 0, -0.5], to: [0, 0, 0.5]}",
                  "torus: {}", "difference: {shapes: [{box: {}}, {sphere: {radius: 9}}]}",
                  "intersection: {shapes: [{box: {}}, {plane: {}}]}", "named: thing"}) {
                const Vec3d at(away * size, 0, 0.5 * size);
                const Scene s =
                    parsed(fmt::format("materials: {{m: {{}}}}\nshapes: {{thing: {{box: {{}}}}}}\nsolver: {{spacing: "
                                       "{0}}}\nbodies: {{b: {{material: m, "
                                       "shape: {{{1}, scale: {2}, translate: [{3}, 0, {4}]}}}}}}\n",
                                       std::max(1e-6, size / 20), shape, size, at.x(), at.z()));
                for (int c = 0; c < 8; ++c)
                    EXPECT_TRUE(in_view(s, at + 0.35 * size * Vec3d(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1)))
                        << shape << ", " << size << ", " << away;
                // It does not stand so far off that nothing is to be seen: the scene is a tenth of the picture's height.
                EXPECT_LT((s.look.camera.position - at).norm(), 40 * size) << shape;
            }
}

TEST(ASceneWithoutALook, HasTheEmitterAndTheFloorInItsPicture) {
    const Scene s = parsed(
        "materials: {m: {}}\nemitters: {tap: {material: m, position: [0, 0, 1]}}\nbodies: {b: {material: "
        "m, shape: {box: {}}}}\nworld: {boundaries: {floor: {shape: {plane: {offset: -1}}}}}\n");
    EXPECT_TRUE(in_view(s, {0, 0, 1}));
    EXPECT_TRUE(in_view(s, {0, 0, -1}));
}

TEST(ASceneWithACamera, KeepsIt) {
    const std::string body = "materials: {m: {}}\nbodies: {b: {material: m, shape: {box: {}}}}\n";
    EXPECT_EQ(parsed(body + "look: {camera: {position: [0, -9, 0]}}\n").look.camera.position, Vec3d(0, -9, 0));
    EXPECT_EQ(parsed(body + "look: {camera: {look_at: [0, 0, 1]}}\n").look.camera.look_at, Vec3d(0, 0, 1));
    EXPECT_TRUE(in_view(parsed(body + "look: {camera: {fov: 10}}\n"), {0.5, 0.5, 0.5}));
}

}  // namespace
}  // namespace thixo::scene
