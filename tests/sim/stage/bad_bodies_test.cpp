// Bodies that no scene should have. Each is refused with one clear line, or simulated without fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <sstream>

#include "pipeline/base/error.h"
#include "pipeline/contract/scene_io.h"
#include "sim/loop/step.h"
#include "sim/stage/setup.h"
#include "tests/pipeline/driver/temporary_folder.h"

namespace thixo {
namespace {

using Place = std::array<double, 3>;

constexpr unsigned kAllFaces = 0b111111;

/// A cube's quads as an OBJ, each corner moved by `place`; `faces` of the six; `turned`: bits of those whose normals
/// point inwards.
std::string cube(const std::function<Place(Place)>& place, int faces = 6, unsigned turned = 0, int first = 1) {
    constexpr int kQuads[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    std::string text;
    for (int corner = 0; corner < 8; ++corner) {
        const Place at = place({corner & 4 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0, corner & 1 ? 1.0 : -1.0});
        text += "v " + std::to_string(at[0]) + " " + std::to_string(at[1]) + " " + std::to_string(at[2]) + "\n";
    }
    for (int f = 0; f < faces; ++f) {
        text += "f";
        for (int k = 0; k < 4; ++k) text += " " + std::to_string(first + kQuads[f][turned >> f & 1 ? 3 - k : k]);
        text += "\n";
    }
    return text;
}

std::function<Place(Place)> scaled(double by) {
    return [by](Place p) -> Place { return {by * p[0], by * p[1], by * p[2]}; };
}

struct Case {
    const char* name;
    std::string mesh;
    const char* refusal;  // part of the message; empty: simulated, with the given volume
    double volume;        // [m^3]
};

std::vector<Case> cases() {
    const auto flat = [](Place p) -> Place { return {0.05 * p[0], 0.05 * p[1], 0}; };
    const auto beside = [](Place p) -> Place { return {0.05 * p[0] + 0.04, 0.05 * p[1] + 0.04, 0.05 * p[2] + 0.04}; };
    const auto aside = [](Place p) -> Place { return {0.05 * p[0] + 0.2, 0.05 * p[1], 0.05 * p[2]}; };
    return {{"good", cube(scaled(0.05)), "", 1e-3},
            {"open", cube(scaled(0.05), 5), "", 1e-3},
            {"inside out", cube(scaled(0.05), 6, kAllFaces), "", 1e-3},
            {"wound both ways", cube(scaled(0.05), 6, 0b010010), "", 1e-3},
            {"of two shells, one inside out", cube(scaled(0.05)) + cube(aside, 6, kAllFaces, 9), "", 2e-3},
            {"of two shells, one of its faces turned", cube(scaled(0.05)) + cube(aside, 6, 0b100, 9), "", 2e-3},
            {"with a byte order mark", "\xef\xbb\xbf" + cube(scaled(0.05)), "", 1e-3},
            {"through itself", cube(scaled(0.05)) + cube(beside, 6, 0, 9), "", 2e-3 - 0.06 * 0.06 * 0.06},
            {"without volume", cube(flat), "holds no particle", 0},
            {"tiny", cube(scaled(1e-5)), "holds no particle", 0},
            {"giant", cube(scaled(1e7)), "too many", 0},
            {"beyond numbers", cube(scaled(1e30)), "must be finite and below", 0},
            {"not a number", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not a finite number", 0},
            {"of points without normals", "v 0 0 0\nv 1 0 0\n", "neither triangles nor points", 0},
            {"with a corner that is not there", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "names vertex 9 of 3", 0},
            {"empty", "", "is empty", 0}};
}

/// Two steps' worth of a frame. Returns the volume of the particles [m^3].
double simulate(const std::filesystem::path& mesh, const std::string& matter) {
    const std::string text = "frames: {first: 0, last: 1, fps: 500}\nmaterials: {stuff: {density: 1000, " + matter +
                             "}}\nbodies: {thing: {material: stuff, shape: {mesh: {file: \"" + mesh.string() +
                             "\", scale: 1}}}}\nsolver: {spacing: 0.01}\n";
    Simulation s = make_simulation(scene::parse_scene(text, (mesh.parent_path() / "bad.yaml").string()));
    advance_frame(s);
    double volume = 0;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        EXPECT_TRUE(s.particles.position[i].allFinite() && s.particles.velocity[i].allFinite());
        volume += static_cast<double>(s.particles.rest_volume[i]);
    }
    return volume;
}

TEST(ABodysMesh, IsRefusedInOneLineOrSimulatedSoundly) {
    const TemporaryFolder folder;
    for (const Case& c : cases())
        for (const char* matter : {"viscosity: 0.1", "youngs_modulus: 1.0e5, poisson_ratio: 0.3"}) {
            SCOPED_TRACE(std::string(c.name) + " of " + matter);
            const auto file = folder.path / "body.obj";
            std::ofstream(file) << c.mesh;
            try {
                const double volume = simulate(file, matter);
                EXPECT_STREQ(c.refusal, "");
                EXPECT_NEAR(volume, c.volume, 0.1 * c.volume);  // layers of 10 in a side
            } catch (const InputError& e) {
                const std::string said = e.what();
                ASSERT_STRNE(c.refusal, "") << said;
                EXPECT_NE(said.find(c.refusal), std::string::npos) << said;
            }
        }
}

TEST(ABodysMesh, ThatIsOpenOrInsideOutIsToldOfOnce) {
    const TemporaryFolder folder;
    const auto said = [&](const std::string& mesh) {
        const auto file = folder.path / "body.obj";
        std::ofstream(file) << mesh;
        const std::string shape = "{mesh: {file: \"" + file.string() + "\", scale: 1}}",
                          text =
                              "frames: {first: 0, last: 1}\nmaterials: {stuff: {youngs_modulus: 1.0e5}}\nbodies:\n"
                              "  one: {material: stuff, shape: " +
                              shape +
                              "}\n"
                              "  row: {material: stuff, shape: {repeat: {count: 3, step: [0, 0.3, 0], shapes: [" +
                              shape + "]}, translate: [1, 0, 0]}}\nsolver: {spacing: 0.02}\n";
        testing::internal::CaptureStderr();
        make_simulation(scene::parse_scene(text, (folder.path / "bad.yaml").string()));
        std::istringstream all(testing::internal::GetCapturedStderr());
        std::string of_meshes;
        for (std::string line; std::getline(all, line);)
            if (line.find("mesh ") != std::string::npos) of_meshes += line + "\n";
        return of_meshes;
    };
    const auto lines = [](const std::string& s) { return std::count(s.begin(), s.end(), '\n'); };
    EXPECT_EQ(said(cube(scaled(0.05))), "");
    const std::string open = said(cube(scaled(0.05), 5)), turned = said(cube(scaled(0.05), 6, kAllFaces)),
                      mixed = said(cube(scaled(0.05), 6, 0b010010));
    EXPECT_NE(open.find("bad.yaml:"), std::string::npos) << open;
    EXPECT_NE(open.find("is not closed (4 open edges, 0 where"), std::string::npos) << open;
    EXPECT_EQ(lines(open), 1) << open;
    EXPECT_NE(turned.find("is inside out"), std::string::npos) << turned;
    EXPECT_EQ(lines(turned), 1) << turned;
    EXPECT_NE(mixed.find("4 of 12 triangles are wound against"), std::string::npos) << mixed;
    EXPECT_EQ(lines(mixed), 1) << mixed;
}

/// A ball of points of 10 cm, with normals of this sign.
std::string ball_of_points(int count, double sign) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) + "\n";
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) text += std::string("property float ") + name + "\n";
    text += "end_header\n";
    for (int k = 0; k < count; ++k) {
        const double z = 1 - (2.0 * k + 1) / count, turn = k * 2.39996322972865332, across = std::sqrt(1 - z * z);
        const Vec3d n(across * std::cos(turn), across * std::sin(turn), z);
        for (const double factor : {0.1, sign})
            for (int a = 0; a < 3; ++a) text += std::to_string(factor * n[a]) + (a == 2 && factor != 0.1 ? "\n" : " ");
    }
    return text;
}

TEST(APointSet, WithInwardNormalsIsToldOfWhateverItIs) {
    const TemporaryFolder folder;
    const std::string
        points = "{mesh: {file: \"" + (folder.path / "points.ply").string() + "\", scale: 1}}",
        body = "bodies: {b: {material: stuff, shape: {box: {size: [0.1, 0.1, 0.1]}, translate: [0.3, 0, 0]}}}\n";
    const std::pair<const char*, std::string> uses[] = {
        {"body", "bodies: {b: {material: stuff, shape: " + points + "}}\n"},
        {"obstacle", body + "world: {boundaries: {rock: {shape: " + points + "}}}\n"},
        {"room",
         "bodies: {b: {material: stuff, shape: {box: {size: [0.1, 0.1, 0.1]}}}}\n"
         "world: {boundaries: {cave: {inside: true, shape: " +
             points + "}}}\n"},
        {"part of an obstacle", body + "world: {boundaries: {rock: {shape: {union: {shapes: [" + points + "]}}}}}\n"},
        {"named obstacle",
         body + "shapes: {stone: " + points + "}\nworld: {boundaries: {rock: {shape: {named: stone}}}}\n"},
        {"mould", body + "surface: {moulds: {m: {reach: 0.1, shape: " + points + "}}}\n"},
        {"source", "emitters: {e: {material: stuff, source: volume, rate: 0.001, shape: " + points + "}}\n"}};
    for (const auto& [use, text] : uses)
        for (const double sign : {1.0, -1.0}) {
            std::ofstream(folder.path / "points.ply") << ball_of_points(500, sign);
            testing::internal::CaptureStderr();
            const Simulation sim = make_simulation(scene::parse_scene(
                "frames: {first: 0, last: 1}\nmaterials: {stuff: {}}\nsolver: {spacing: 0.02}\n" + text,
                (folder.path / "bad.yaml").string()));
            const std::string said = testing::internal::GetCapturedStderr();
            const std::size_t told = said.find("points.ply has normals that point inward");
            EXPECT_EQ(told != std::string::npos, sign < 0) << use << ": " << said;
            EXPECT_EQ(said.find("bad.yaml:") != std::string::npos, sign < 0) << use << ": " << said;
            const Vec3 in(0.3, 0, 0), out(0, 0, 0);
            if (std::string(use) == "obstacle") {
                EXPECT_GT(wall_distance(sim.walls, in), 0) << "the rock is where its points are";
                EXPECT_LT(wall_distance(sim.walls, out), 0);
            }
        }
}

TEST(AMaterial, OfNoMassOrThatCannotChangeItsVolumeIsRefused) {
    for (const char* matter : {"density: 0", "density: -1", "density: 1000, youngs_modulus: 1.0e5, poisson_ratio: 0.5",
                               "density: 1000, youngs_modulus: 1.0e5, poisson_ratio: -1"})
        EXPECT_THROW(
            scene::parse_scene(std::string("frames: {first: 0, last: 1}\nmaterials: {stuff: {") + matter + "}}\n",
                               "bad.yaml"),
            InputError)
            << matter;
}

TEST(AnOrthotropicMaterial, ThatCannotBeIsRefusedInOneLine) {
    const std::string moduli = "youngs_modulus: [1.0e5, 1.0e5, 1.0e5], shear_modulus: [4.0e4, 4.0e4, 4.0e4], ",
                      good = "orthotropic: {" + moduli + "poisson_ratio: [0.2, 0.2, 0.2]}",
                      solid = "youngs_modulus: 1.0e5, ";
    const auto refusal = [](const std::string& keys) {
        try {
            scene::parse_scene(
                "frames: {first: 0, last: 1}\nmaterials: {stuff: {" + keys + "}, other: {youngs_modulus: 1.0e5}}\n",
                "bad.yaml");
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_EQ(refusal(solid + good), "");
    const std::pair<std::string, const char*> cases[] = {
        {solid + "orthotropic: {youngs_modulus: [1.0e5, 1.0e5, 1.0e5], poisson_ratio: [0.2, 0.2, 0.2]}",
         "three moduli"},
        {solid + "orthotropic: {" + moduli + "poisson_ratio: [0.9, 0.9, 0.9]}", "poisson_ratio"},
        {good, "only a solid"},
        {solid + good + ", changes: [{time: 1, material: other}]", "not supported yet"}};
    for (const auto& [keys, part] : cases) {
        const std::string said = refusal(keys);
        EXPECT_NE(said.find(part), std::string::npos) << keys << ": " << said;
    }
}

TEST(ASolidThatDiverges, StopsWithItsParticleFrameAndLikelyCause) {
    // A handle pulls a block away at 10 km/s.
    Simulation s = make_simulation(
        scene::parse_scene("frames: {first: 0, last: 9, fps: 100}\n"
                           "materials: {stuff: {density: 1000, youngs_modulus: 1.0e4}}\n"
                           "bodies: {thing: {material: stuff, shape: {box: {size: [0.06, 0.06, 0.06]}}}}\n"
                           "handles: {hand: {body: thing, region: {box: {size: [1, 1, 0.03]}, translate: [0, 0, 0.03]},"
                           " motion: [{time: 0}, {time: 0.1, position: [1000, 0, 0]}]}}\n"
                           "solver: {spacing: 0.01}\n",
                           "fast.yaml"));
    std::string said;
    try {
        while (s.clock.frame < 9) advance_frame(s);
    } catch (const DivergedError& e) {
        said = e.what();
    }
    for (const char* part :
         {"of particle ", "of body 'thing'", "on the way to frame ", "likely: ", "replay: thixo sim "})
        EXPECT_NE(said.find(part), std::string::npos) << part << " in " << said;
}

TEST(AWall, ThatCannotBeIsRefusedInOneLine) {
    const TemporaryFolder folder;
    const auto file = folder.path / "wall.obj";
    const auto refusal = [&](const std::string& wall) {
        try {
            make_simulation(scene::parse_scene(
                "frames: {first: 0, last: 1}\nmaterials: {stuff: {}}\nworld: {boundaries: {wall: {" + wall +
                    "}}}\nbodies: {drop: {material: stuff, shape: {sphere: {radius: 0.1}}}}\nsolver: {spacing: 0.02}\n",
                (folder.path / "bad.yaml").string()));
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    const std::string box = "shape: {box: {size: [1, 1, 0.1]}, translate: [0, 0, -0.5]}";
    EXPECT_EQ(refusal(box), "");
    const std::string turned = refusal(box + ", motion: [{time: 0}, {time: 1, rotate: [0, 0, 180]}]");
    EXPECT_NE(turned.find("bad.yaml:3:"), std::string::npos) << turned;
    EXPECT_NE(turned.find("180 degrees or more"), std::string::npos) << turned;
    // The error comes while the simulation is being made, when parts of it exist already.
    for (const Case& c : cases()) {
        if (std::string(c.refusal) != "is empty" && std::string(c.name) != "of points without normals") continue;
        std::ofstream(file) << c.mesh;
        const std::string said = refusal("shape: {mesh: {file: \"" + file.string() + "\", scale: 1}}");
        EXPECT_NE(said.find(c.refusal), std::string::npos) << c.name << ": " << said;
    }
}

TEST(ABodysMesh, OfNormalsWithoutLengthFacesOutwards) {
    const TemporaryFolder folder;
    const auto file = folder.path / "body.obj";
    std::string mesh = cube(scaled(0.05)), text;
    std::istringstream lines(mesh);
    for (std::string line; std::getline(lines, line);) {
        if (line[0] == 'f') {
            std::istringstream words(line.substr(1));
            std::string with;
            for (int v; words >> v;) with += " " + std::to_string(v) + "//" + std::to_string(v);
            line = "f" + with;
        }
        text += line + "\n";
        if (line[0] == 'v') text += "vn 0 0 0\n";
    }
    std::ofstream(file) << text;
    testing::internal::CaptureStderr();
    const Simulation s = make_simulation(
        scene::parse_scene("frames: {first: 0, last: 1}\nmaterials: {stuff: {youngs_modulus: 1.0e5}}\nbodies: {thing: "
                           "{material: stuff, surfels: 600, shape: {mesh: {file: \"" +
                               file.string() + "\", scale: 1}}}}\nsolver: {spacing: 0.02}\n",
                           (folder.path / "bad.yaml").string()));
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("8 normals without a length"), std::string::npos) << said;
    ASSERT_GT(s.embedded.size(), 300u);
    for (std::size_t i = 0; i < s.embedded.size(); ++i)
        EXPECT_NEAR(s.embedded.rest.normal[i].dot(s.embedded.rest.position[i]), 0.05,
                    2e-3);  // about the mean of its particles
}

}  // namespace
}  // namespace thixo
