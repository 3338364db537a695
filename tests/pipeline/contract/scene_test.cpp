#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "pipeline/base/error.h"
#include "pipeline/contract/picture_cost.h"
#include "pipeline/contract/scene_hash.h"
#include "pipeline/contract/scene_io.h"
#include "pipeline/contract/scene_origin.h"
#include "pipeline/contract/scene_walk.h"
#include "tests/pipeline/contract/entry.h"

namespace thixo::scene {
namespace {

namespace fs = std::filesystem;
const std::string kScenes = std::string(THIXO_SOURCE_DIR) + "/tests/pipeline/contract/scenes/";

Scene pour() { return load_scene(kScenes + "pour.yaml"); }

TEST(Scene, APouringSceneIsReadAsWritten) {
    const Scene s = pour();
    EXPECT_EQ(s.name, "pour");
    EXPECT_EQ(s.title, "Water: poured into a glass");
    EXPECT_EQ(s.frames.last, 120);
    ASSERT_EQ(s.shapes.size(), 1u);
    EXPECT_EQ(std::get<Revolve>(s.shapes[0].second.kind).profile.size(), 6u);
    EXPECT_EQ(std::get<Revolve>(s.shapes[0].second.kind).profile[1], Vec2d(0.04, 0));
    ASSERT_EQ(s.world.boundaries.size(), 3u);  // in the file's order
    EXPECT_EQ(s.world.boundaries[0].name, "glass");
    EXPECT_EQ(s.world.boundaries[1].name, "floor");
    EXPECT_EQ(s.world.boundaries[2].name, "room");
    EXPECT_EQ(std::get<NamedShape>(s.world.boundaries[0].shape.kind).name, "cup");
    EXPECT_EQ(s.world.boundaries[0].shape.translate, Vec3d(0, 0, 0.001));
    ASSERT_EQ(s.world.boundaries[0].motion.size(), 2u);
    EXPECT_EQ(s.world.boundaries[0].motion[1].rotate, Vec3d(0, 30, 0));
    EXPECT_TRUE(s.world.boundaries[1].no_slip);
    EXPECT_EQ(s.world.boundaries[1].look, "ground");
    EXPECT_TRUE(s.world.boundaries[2].inside);
    EXPECT_FALSE(s.world.boundaries[2].visible);
    EXPECT_EQ(entry(s.materials, "water").density, 998);
    const auto& rest = std::get<Intersection>(s.bodies[0].shape.kind);
    EXPECT_EQ(rest.smooth, 0.001);
    EXPECT_EQ(std::get<Cylinder>(rest.shapes[0].kind).height, 0.02);
    EXPECT_EQ(rest.shapes[1].offset, -0.001);
    EXPECT_EQ(s.emitters[0].jitter, 0.1);
    EXPECT_EQ(s.solver.seed, ~std::uint64_t{0});
    EXPECT_EQ(s.solver.time_step.maximum, 0.002);
    EXPECT_EQ(entry(s.look.lights, "sun").type, LightType::sun);
    EXPECT_EQ(entry(s.look.appearances, "water").type, AppearanceType::dielectric);
    EXPECT_EQ(entry(s.look.appearances, "water").absorption, Vec3d(9, 2.5, 1));
    EXPECT_NE(s.world.boundaries[0].shape.where.find("pour.yaml:11:14"), std::string::npos)
        << s.world.boundaries[0].shape.where;
}

TEST(Scene, EveryKindOfShapeIsRead) {
    const Scene s = parse_scene(R"(
shapes:
  a: {sphere: {radius: 2}}
  b: {ellipsoid: {radii: [1, 2, 3]}}
  c: {box: {size: [1, 2, 3], rounding: 0.1}, scale: 2, rotate: [1, 2, 3], translate: [4, 5, 6], offset: -0.1, shell: 0.2}
  d: {cylinder: {radius: 1, height: 2, rounding: 0.5}}
  e: {rounded_cone: {radius1: 1, radius2: 0.5, height: 2}}
  f: {capsule: {from: [0, 0, 0], to: [1, 0, 0], radius: 0.1}}
  g: {torus: {radius: 1, tube: 0.2}}
  h: {plane: {normal: [0, 1, 0], offset: 3}}
  i: {revolve: {profile: [[0, 0], [1, 0], [0, 1]]}}
  j: {union: [{named: a}, {named: {name: b}}]}
  k: {intersection: {shapes: [{sphere: }], smooth: 0.5}}
  l: {difference: [{box: {}}, {sphere: {radius: 0.2}}, {union: [{torus: {}}]}]}
  m: {sweep: {points: [{at: [0, 0, 0], radius: 0.2}, {at: [1, 0, 0.5]}], closed: false}}
  n: {mirror: {shapes: [{named: a}], normal: [0, 1, 0], offset: 0.5, smooth: 0.1}}
  o: {repeat: {shapes: [{named: a}, {named: b}], count: 5, step: [0, 0, 1], turn: 30}}
  p: {twist: {shapes: [{named: c}], rate: 45}}
  q: {bend: {shapes: [{named: c}], angle: -90}}
  r: {noise: {shapes: [{named: a}], amplitude: 0.02, scale: 0.5, octaves: 2}}
)",
                                "text.yaml");
    ASSERT_EQ(s.shapes.size(), 18u);
    // Places in the variant; the mesh, 11, needs a file.
    const std::vector<std::size_t> kinds = {1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 13, 14, 10, 15, 16, 17, 18, 19};
    for (std::size_t k = 0; k < kinds.size(); ++k)
        EXPECT_EQ(s.shapes[k].second.kind.index(), kinds[k]) << s.shapes[k].first;
    const Shape& box = s.shapes[2].second;
    EXPECT_EQ(box.scale, 2);
    EXPECT_EQ(box.rotate, Vec3d(1, 2, 3));
    EXPECT_EQ(box.translate, Vec3d(4, 5, 6));
    EXPECT_EQ(box.offset, -0.1);
    EXPECT_EQ(box.shell, 0.2);
    EXPECT_EQ(std::get<Union>(s.shapes[9].second.kind).shapes.size(), 2u);
    EXPECT_EQ(std::get<Intersection>(s.shapes[10].second.kind).smooth, 0.5);
    EXPECT_EQ(std::get<Sweep>(s.shapes[12].second.kind).points[1].at, Vec3d(1, 0, 0.5));
    EXPECT_EQ(std::get<Mirror>(s.shapes[13].second.kind).smooth, 0.1);
    EXPECT_EQ(std::get<Repeat>(s.shapes[14].second.kind).shapes.size(), 2u);
}

TEST(Scene, TheShortestUsefulSceneHasTenLines) {
    const Scene s = parse_scene(R"(materials:
  water:
bodies:
  drop: {material: water, shape: {sphere: {radius: 0.1}, translate: [0, 0, 0.5]}}
world:
  boundaries:
    floor: {shape: {plane: {}}}
solver: {spacing: 0.02}
)",
                                "folder/my drop.yaml");
    EXPECT_EQ(s.name, "my_drop");
    // The defaults are enough to see the scene: a sky, a sun, and an appearance for everything that has none.
    EXPECT_EQ(s.look.lights.size(), 2u);
    EXPECT_EQ(s.materials[0].look, "water");
    EXPECT_EQ(s.world.boundaries[0].look, "floor");
    EXPECT_EQ(entry(s.look.appearances, "water").type, AppearanceType::dielectric);
    EXPECT_NO_THROW(entry(s.look.appearances, "floor"));
    EXPECT_TRUE(scene_warnings(s).empty());
}

TEST(Scene, PrintedAndReadAgainItIsTheSame) {
    for (const char* file : {"pour.yaml", "pour_honey.yaml"}) {
        Scene s = load_scene(kScenes + file);
        s.title = "quotes \" ' \\ # : - {x} [y], tabs\t, lines\n, ünï, &a *b !c %d @e `f` ~";
        s.solver.spacing = 0.1 + 0.2;  // needs 17 digits
        s.solver.artificial_viscosity = 1.0 / 3.0;
        s.emitters[0].stop = 1e9;
        s.emitters[0].position = Vec3d(-0.0, 5e-324, 1e-7);
        const std::string text = print_scene(s);
        const Scene again = parse_scene(text, "again.yaml", {}, Files::ignore);
        EXPECT_EQ(text, print_scene(again));
        EXPECT_EQ(again.title, s.title);
        EXPECT_EQ(again.solver.spacing, s.solver.spacing);
        EXPECT_EQ(again.solver.seed, s.solver.seed);
        EXPECT_EQ(again.emitters[0].position, s.emitters[0].position);
        EXPECT_EQ(simulation_hash(again), simulation_hash(s));
        EXPECT_EQ(look_hash(again.look), look_hash(s.look));
    }
}

TEST(Scene, MayBeginWithAByteOrderMarkAndEndItsLinesAsAnySystemDoes) {
    const std::vector<std::string> lines{"frames: {last: 3}", "materials:", "  m: {}", "solver: {spacing: 0.02}"};
    for (const std::string mark : {"", "\xef\xbb\xbf"})
        for (const std::string end : {"\n", "\r\n", "\r"}) {
            std::string text = mark;
            for (const std::string& line : lines) text += line + end;
            const Scene s = parse_scene(text, "lines.yaml");
            EXPECT_EQ(s.frames.last, 3);
            EXPECT_EQ(s.materials.size(), 1u);
            EXPECT_EQ(s.solver.spacing, 0.02);
            try {
                parse_scene(text + "surfce: {}" + end, "lines.yaml");
                ADD_FAILURE() << "read";
            } catch (const InputError& error) {
                EXPECT_NE(std::string(error.what()).find("lines.yaml:5:1: error: unknown"), std::string::npos)
                    << error.what();
            }
        }
}

TEST(Scene, NamesThatYamlTakesForOtherThingsSurvivePrinting) {
    const std::vector<std::string> names = {"null", "true", "017", "no", "1e3", "0x1F", "_", "y"};
    std::string text = "materials:\n";
    for (const std::string& name : names) text += "  \"" + name + "\": {}\n";
    Scene s = parse_scene(text, "x.yaml");
    for (const char* title :
         {"", "null", "~", "true", "12", "1e3", "017", "no", "- a", "a: b", " a ", "<<", "%a", "|", "# a"}) {
        s.title = title;
        const Scene again = parse_scene(print_scene(s), "again.yaml", {}, Files::ignore);
        EXPECT_EQ(again.title, title);
        ASSERT_EQ(again.materials.size(), names.size());
        for (std::size_t k = 0; k < names.size(); ++k) EXPECT_EQ(again.materials[k].name, names[k]);
    }
}

TEST(Scene, ExtendsLaysOneFileOverTheOtherByName) {
    const Scene base = pour(), s = load_scene(kScenes + "pour_honey.yaml");
    EXPECT_EQ(s.name, "pour_honey");
    EXPECT_EQ(s.title, base.title);
    EXPECT_EQ(s.frames.last, 60);
    EXPECT_EQ(s.frames.fps, base.frames.fps);
    EXPECT_EQ(s.materials.size(), 2u);
    EXPECT_EQ(entry(s.materials, "water").viscosity, 5);
    EXPECT_EQ(entry(s.materials, "water").density, 998);  // what is not mentioned stays
    EXPECT_EQ(s.emitters[0].material, "oil");
    EXPECT_EQ(s.emitters[0].radius, base.emitters[0].radius);
    EXPECT_EQ(std::get<Sphere>(s.bodies[0].shape.kind).radius, 0.02);  // another kind replaces the kind
    EXPECT_EQ(entry(s.look.lights, "sun").strength, 1);
    EXPECT_EQ(entry(s.look.lights, "sun").angle, 0.6);
    EXPECT_EQ(s.look.lights.size(), 3u);
    EXPECT_EQ(print_look(s.look).substr(0, 300), print_look(base.look).substr(0, 300));  // the camera
}

TEST(Scene, OverridesSetSingleKeysInTheirOrder) {
    const Scene s =
        load_scene(kScenes + "pour.yaml",
                   {"solver.spacing=0.5", "solver.spacing=0.01", "materials.water.viscosity=2e-3",
                    "world.gravity=[0, 0, -1.62]", "surface.enabled=false", "look.output.view=srgb",
                    "scene.title=a = b", "world.boundaries.glass.motion.1.time=9", "shapes.cup.revolve.1=[0.05, 0]",
                    "look.camera={fov: 50}", "bodies.rest.shape={sphere: {radius: 0.3}}"});
    EXPECT_EQ(s.solver.spacing, 0.01);
    EXPECT_EQ(s.materials[0].viscosity, 2e-3);
    EXPECT_EQ(s.materials[0].density, 998);
    EXPECT_EQ(s.world.gravity, Vec3d(0, 0, -1.62));
    EXPECT_FALSE(s.surface.enabled);
    EXPECT_EQ(s.look.output.view, ViewTransform::srgb);
    EXPECT_EQ(s.title, "a = b");
    EXPECT_EQ(s.world.boundaries[0].motion[1].time, 9);
    EXPECT_EQ(std::get<Revolve>(s.shapes[0].second.kind).profile[1], Vec2d(0.05, 0));
    EXPECT_EQ(s.look.camera.fov, 50);
    EXPECT_EQ(s.look.camera.position, Vec3d(0.1, -0.6, 0.25));
    EXPECT_EQ(std::get<Sphere>(s.bodies[0].shape.kind).radius, 0.3);
}

TEST(Scene, DraftIsCoarser) {
    Scene s = load_scene(kScenes + "pour.yaml", {}, true);
    EXPECT_EQ(s.solver.spacing, 0.008);  // half the particles per axis
    EXPECT_EQ(s.look.output.width, 640);
    EXPECT_EQ(s.look.output.height, 360);
    EXPECT_EQ(s.look.output.samples, 16);
    EXPECT_TRUE(s.look.output.denoise);
    s.look.output.samples = 9;
    apply_draft(s);
    EXPECT_EQ(s.look.output.samples, 4);
    s.look.output.samples = 1;
    s.look.output.width = 1;
    apply_draft(s);
    EXPECT_EQ(s.look.output.samples, 1);  // never more than there were
    EXPECT_FALSE(s.look.output.denoise);  // which needs two
    EXPECT_EQ(s.look.output.width, 1);
}

TEST(Look, AFileOfLightsKeepsCameraAndAppearances) {
    const Look base = pour().look;
    const Look look = overlay_look(base, kScenes + "lamp_look.yaml", {"look.output.samples=3", "solver.spacing=1"});
    EXPECT_EQ(look.lights.size(), 3u);
    EXPECT_EQ(entry(look.lights, "sun").strength, 7);
    EXPECT_EQ(entry(look.lights, "sun").angle, 0.6);
    EXPECT_EQ(entry(look.lights, "lamp").type, LightType::area);
    EXPECT_EQ(look.camera.position, base.camera.position);
    EXPECT_EQ(look.appearances.size(), base.appearances.size());
    EXPECT_EQ(look.output.samples, 3);
    EXPECT_EQ(look.output.width, base.output.width);
}

TEST(Look, AimsALightByDirectionOrByTarget) {
    const auto lamp = [](const Look& look) { return entry(look.lights, "lamp"); };
    const std::string text =
        "materials: {water: {}}\nlook: {lights: {lamp: {type: area, position: [0, 0, 2], look_at: [1, 0, 0]}}}\n";
    const Scene base = parse_scene(text, "x.yaml");
    EXPECT_EQ(light_direction(lamp(base.look)), Vec3d(1, 0, -2));
    EXPECT_FALSE(lamp(base.look).direction);
    // It goes through the cache, follows the lamp, and gives way to a direction.
    const Scene cached = parse_cached_scene(print_cached_scene(base), "manifest.json");
    EXPECT_EQ(light_direction(lamp(cached.look)), Vec3d(1, 0, -2));
    EXPECT_EQ(light_direction(lamp(overlay_look(cached.look, "", {"look.lights.lamp.position=[0, 0, 1]"}))),
              Vec3d(1, 0, -1));
    const Look turned = overlay_look(cached.look, "", {"look.lights.lamp.direction=[0, 1, 0]"});
    EXPECT_EQ(light_direction(lamp(turned)), Vec3d(0, 1, 0));
    EXPECT_FALSE(lamp(turned).look_at);
    const Look back = overlay_look(turned, "", {"look.lights.lamp.look_at=[0, 0, 0]"});
    EXPECT_EQ(light_direction(lamp(back)), Vec3d(0, 0, -2));
    EXPECT_FALSE(lamp(back).direction);
    const Look far = relative_to(base.look, {10, 20, 30});
    EXPECT_EQ(light_direction(lamp(far)), Vec3d(1, 0, -2));
    EXPECT_EQ(light_direction(entry(parse_scene("look: {lights: {lamp: {type: area}}}", "x.yaml").look.lights, "lamp")),
              Vec3d(0, 0, -1));
    EXPECT_NE(look_hash(turned), look_hash(back));
    for (const Look* under : {&base.look, &turned})
        EXPECT_EQ(light_direction(lamp(overlay_look(*under, kScenes + "aimed_again_look.yaml"))), Vec3d(0, 1, -2));
}

TEST(Look, MayExtendAnotherAndStandInABlock) {
    const Look look = overlay_look(pour().look, kScenes + "night_look.yaml");
    EXPECT_EQ(look.background, Vec3d(0, 0, 0.01));
    EXPECT_EQ(entry(look.lights, "sun").strength, 0.5);
}

TEST(Look, OfNothingIsTheBase) {
    const Look base = pour().look;
    EXPECT_EQ(print_look(overlay_look(base, "")), print_look(base));
}

TEST(Look, AWholeSceneIsNoLook) {
    try {
        overlay_look(pour().look, kScenes + "pour.yaml");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("pour.yaml:2:1: error: a look file holds nothing beside"),
                  std::string::npos)
            << e.what();
    }
    EXPECT_THROW(overlay_look(pour().look, kScenes + "none.yaml"), InputError);
    EXPECT_THROW(overlay_look(pour().look, kScenes + "loop_a.yaml"), InputError);
}

TEST(SceneHash, OfTheSimulationDoesNotDependOnTheLook) {
    const std::string file = kScenes + "pour.yaml";
    const std::string hash = simulation_hash(pour());
    for (const char* set : {"look.camera.fov=20", "look.lights.sun.strength=1", "look.output.width=10",
                            "frames.last=500", "scene.title=x", "scene.name=x", "solver.checkpoint_every=3"})
        EXPECT_EQ(simulation_hash(load_scene(file, {set})), hash) << set;
    for (const char* set :
         {"solver.spacing=0.0041", "materials.water.viscosity=0.0011", "frames.fps=25", "frames.first=2",
          "world.gravity=[0, 0, -9.8]", "solver.seed=2", "emitters.spout.stop=3", "surface.iterations=5",
          "shapes.cup.revolve.1=[0.05, 0]", "world.boundaries.glass.motion.1.rotate=[0, 31, 0]",
          "bodies.rest.shape.intersection.shapes.1.offset=0"})
        EXPECT_NE(simulation_hash(load_scene(file, {set})), hash) << set;
}

TEST(SceneHash, OfTheLookDependsOnTheLookAlone) {
    const std::string file = kScenes + "pour.yaml";
    const std::string hash = look_hash(pour().look);
    EXPECT_EQ(look_hash(load_scene(file, {"solver.spacing=1"}).look), hash);
    EXPECT_EQ(look_hash(load_scene(file, {"look.output.film=false"}).look), hash);
    for (const char* set :
         {"look.camera.fov=20", "look.lights.sun.strength=1", "look.output.samples=3", "look.background=[0, 0, 0]"})
        EXPECT_NE(look_hash(load_scene(file, {set}).look), hash) << set;
}

TEST(SceneHash, DifferingKeysAreNamed) {
    const Scene a = pour();
    const Scene b = load_scene(kScenes + "pour.yaml", {"solver.spacing=0.01", "materials.water.viscosity=0.5",
                                                       "look.camera.fov=3", "frames.last=7"});
    EXPECT_EQ(differing_keys(a, b), (std::vector<std::string>{"materials.water.viscosity", "solver.spacing"}));
    EXPECT_TRUE(differing_keys(a, a).empty());
    Scene c = a;
    std::swap(c.world.boundaries[0], c.world.boundaries[1]);
    EXPECT_NE(simulation_hash(a), simulation_hash(c));
    EXPECT_EQ(differing_keys(a, c), (std::vector<std::string>{"world.boundaries (the order of its entries)"}));
    Scene d = a;
    d.emitters.clear();
    EXPECT_FALSE(differing_keys(a, d).empty());
    EXPECT_FALSE(differing_keys(d, a).empty());
}

TEST(SceneHash, FollowsAMeshsContentNotItsPlace) {
    const fs::path folder = fs::path(testing::TempDir()) / "thixo_scene_mesh";
    fs::create_directories(folder / "models");
    const auto write = [&](const char* name, const char* text) { std::ofstream(folder / name) << text; };
    write("models/a.obj", "v 0 0 0\n");
    write("models/b.obj", "v 0 0 0\n");
    write("models/c.obj", "v 0 0 1\n");
    write("scene.yaml",
          "materials: {m: {}}\nbodies: {bust: {material: m, shape: {mesh: {file: models/a.obj, height: 1}}}}\n");
    const std::string file = (folder / "scene.yaml").string();
    const Scene a = load_scene(file);
    EXPECT_EQ(std::get<MeshFile>(a.bodies[0].shape.kind).file,
              (folder / "models/a.obj").string());  // relative to the scene's file
    const auto with = [&](const char* mesh) {
        return load_scene(file, {fmt::format("bodies.bust.shape.mesh.file={}", (folder / mesh).string())});
    };
    EXPECT_EQ(simulation_hash(with("models/b.obj")), simulation_hash(a));
    EXPECT_NE(simulation_hash(with("models/c.obj")), simulation_hash(a));
    EXPECT_EQ(differing_keys(a, with("models/c.obj")), (std::vector<std::string>{"bodies.bust.shape.mesh.content"}));
    const std::string text = print_scene(a);
    fs::remove_all(folder);
    // A cache's scene outlives its files.
    EXPECT_EQ(simulation_hash(parse_scene(text, "manifest.json", {}, Files::ignore)), simulation_hash(a));
    EXPECT_EQ(print_scene(parse_scene(text, "manifest.json", {}, Files::ignore)), text);
    EXPECT_THROW(parse_scene(text, "scene.yaml"), InputError);
}

TEST(SceneWarnings, NameWhatIsProbablyNotMeant) {
    const Scene s = load_scene(kScenes + "pour_honey.yaml",
                               {"solver.spacing=0.02", "emitters.spout.start=3", "emitters.spout.material=water"});
    const std::vector<std::string> warnings = scene_warnings(s);
    ASSERT_EQ(warnings.size(), 3u);
    EXPECT_NE(warnings[0].find("materials.oil is not used"), std::string::npos);
    EXPECT_NE(warnings[1].find("emitters.spout.radius 0.01 m is below solver.spacing 0.02 m"), std::string::npos);
    EXPECT_NE(warnings[2].find("emitters.spout starts at 3 s, after the last frame"), std::string::npos);
    EXPECT_TRUE(scene_warnings(pour()).empty());
    EXPECT_EQ(scene_warnings(parse_scene("frames: {last: 2}", "x.yaml")).size(), 1u);
}

TEST(SceneWarnings, NameKeysThatDoNothingUnderTheSolver) {
    const auto warnings = [](const std::string& solver, const std::string& material) {
        std::string all;
        for (const std::string& w : scene_warnings(parse_scene(
                 "materials: {water: {" + material +
                     "}}\nbodies: {drop: {material: water, shape: {sphere: {radius: 1}}}}\nsolver: {spacing: 0.1, " +
                     solver + "}",
                 "x.yaml")))
            all += w + '\n';
        return all;
    };
    const std::string implicit = warnings("pressure: dfsph, artificial_viscosity: 0.01", "gamma: 2, stiffness: 1e4");
    for (const char* key : {"solver.artificial_viscosity", "materials.water.gamma", "materials.water.stiffness"})
        EXPECT_NE(implicit.find(key + std::string(" does nothing with `pressure: dfsph`")), std::string::npos) << key;
    const std::string state = warnings("iterations: 7, density_tolerance: 0.01, divergence_tolerance: 0.01", "");
    for (const char* key : {"solver.iterations", "solver.density_tolerance", "solver.divergence_tolerance"})
        EXPECT_NE(state.find(key + std::string(" does nothing without `pressure: dfsph`")), std::string::npos) << key;
    const std::string steps = warnings(
        "viscosity: explicit, viscosity_tolerance: 0.1, solids_tolerance: 0.1, time_step: {fixed: 0.01, cfl: 0.1}", "");
    for (const char* key : {"solver.viscosity_tolerance", "solver.solids_tolerance", "solver.time_step.cfl"})
        EXPECT_NE(steps.find(key + std::string(" does nothing with")), std::string::npos) << key;
    const std::string plastic =
        warnings("support: 2", "youngs_modulus: 1e5, yield_strain: 0.1, hardening: 1, flow: deviatoric");
    for (const char* key : {"yield_strain", "hardening", "flow"})
        EXPECT_NE(plastic.find("materials.water." + std::string(key) + " does nothing without `creep`"),
                  std::string::npos)
            << key;
    EXPECT_TRUE(warnings("pressure: dfsph, iterations: 7", "").empty());
    EXPECT_TRUE(warnings("artificial_viscosity: 0.01", "gamma: 2").empty());
    EXPECT_TRUE(warnings("support: 2", "youngs_modulus: 1e5, yield_strain: 0.1, creep: 5").empty());
}

TEST(PictureCost, OfWhatGlowsIsThatOfOneMoreLightGroup) {
    const auto cost = [](const std::string& more) {
        const Scene s = parse_scene(
            "look:\n  output: {passes: {lights: true}, denoise: true}\n  appearances: {stone: {type: diffuse}}\n"
            "  lights: {sky: {type: sky}, lamp: {type: point, group: sky}}\n",
            "x.yaml", {more});
        return picture_cost(s.look, nullptr);
    };
    const PictureCost plain = cost("look.output.film=true"), group = cost("look.lights.lamp.group=lamp"),
                      glow = cost("look.appearances.stone.glow.strength=1");
    EXPECT_GT(group.memory, plain.memory);
    EXPECT_EQ(glow.memory, group.memory);
    EXPECT_EQ(glow.disk_per_frame, group.disk_per_frame);
}

TEST(SceneWarnings, NameKeysOfLightThatDoNothing) {
    const Scene s = parse_scene(
        "look:\n  lights: {sun: {type: sun, look_at: [0, 0, 1]}}\n"
        "  appearances: {lava: {glow: {black_body: 1000, colour: [1, 0, 0]}}}\n",
        "x.yaml");
    std::string all;
    for (const std::string& w : scene_warnings(s)) all += w + '\n';
    EXPECT_NE(all.find("look.lights.sun.look_at does nothing with `type: sun`"), std::string::npos) << all;
    for (const char* key : {"colour", "black_body"})
        EXPECT_NE(all.find(fmt::format("look.appearances.lava.glow.{} does nothing without `strength`", key)),
                  std::string::npos)
            << all;
}

TEST(Scene, FractureOfFrozenMatterWithoutASurfaceIsToldOf) {
    const auto told = [](const std::string& surface) {
        const Scene s = parse_scene(
            "materials: {wax: {youngs_modulus: 1.0e5, fracture: {strength: 1000}, "
            "melting: {from: 40, to: 60}}}\nsurface: {enabled: " +
                surface + "}\n",
            "scene.yaml");
        return std::ranges::count_if(idle_keys(s), [](const std::string& line) {
            return line.starts_with("materials.wax.fracture does nothing in matter that has melted and frozen");
        });
    };
    EXPECT_EQ(told("false"), 1);
    EXPECT_EQ(told("true"), 0);
}

TEST(Scene, KeysThatAProbesMeasureDoesNotReadAreTold) {
    const auto told = [](const std::string& probe) {
        std::string all;
        for (const std::string& line :
             idle_keys(parse_scene("materials: {water: {}}\nprobes: {p: {" + probe + "}}\n", "scene.yaml")))
            all += line + "\n";
        return all;
    };
    EXPECT_EQ(told("measure: mean, quantity: z, material: water, region: {sphere: {radius: 1}}"), "");
    EXPECT_EQ(told("measure: mean, quantity: angular_z, position: [1, 0, 0]"), "");
    EXPECT_EQ(told("measure: mean, quantity: z, position: [1, 0, 0]"),
              "probes.p.position does nothing with `measure: mean`\n");
    EXPECT_EQ(told("measure: wall_pressure, position: [1, 0, 0], direction: [1, 0, 0], radius: 1"),
              "probes.p measures what presses on walls, and there is none\n");
    EXPECT_THROW(told("measure: wall_pressure"), InputError);
    EXPECT_EQ(told("measure: bodies, material: water, quantity: z, region: {sphere: {radius: 1}}"),
              "probes.p.quantity does nothing with `measure: bodies`\n"
              "probes.p.material does nothing with `measure: bodies`\n"
              "probes.p.region does nothing with `measure: bodies`\n");
    EXPECT_EQ(told("measure: extent, direction: [1, 0, 0], quantile: 0.5, radius: 2"),
              "probes.p.radius does nothing with `measure: extent`\n");
}

TEST(SceneWarnings, NameWhatMixesLiquids) {
    const auto warnings = [](const char* artificial) {
        return scene_warnings(parse_scene(std::string("materials: {water: {}, oil: {density: 100}}\nbodies: {a: "
                                                      "{material: water, shape: {sphere: {radius: 1}}}, b: {material: "
                                                      "oil, shape: {sphere: {radius: 1}, translate: [3, 0, 0]}}}\n"
                                                      "solver: {spacing: 0.1, artificial_viscosity: ") +
                                              artificial + "}",
                                          "x.yaml"));
    };
    ASSERT_EQ(warnings("0.01").size(), 1u);
    EXPECT_NE(warnings("0.01")[0].find("liquids of different density mix"), std::string::npos);
    EXPECT_TRUE(warnings("0.15").empty());
}

}  // namespace
}  // namespace thixo::scene
