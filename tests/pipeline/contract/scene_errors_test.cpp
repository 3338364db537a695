// Wrong scenes. The comments of each file in bad_scenes/ say which errors must be reported, and where:
//     # expect: LINE:COLUMN: part of the message    (or without a place), one for each error
//     # hint: part of the text behind the caret
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "pipeline/base/error.h"
#include "pipeline/contract/scene_io.h"
#include "tests/pipeline/contract/cache_fixture.h"

namespace thixo::scene {
namespace {

namespace fs = std::filesystem;
const fs::path kFolder = fs::path(THIXO_SOURCE_DIR) / "tests/pipeline/contract";

std::vector<std::string> bad_scenes() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(kFolder / "bad_scenes"))
        names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

std::string errors_of(const std::string& path) {
    try {
        load_scene(path);
    } catch (const InputError& e) {
        return e.what();
    }
    return {};
}

std::string errors_of_text(const std::string& text, const std::vector<std::string>& overrides = {},
                           const std::string& name = "text.yaml") {
    try {
        parse_scene(text, name, overrides);
    } catch (const InputError& e) {
        return e.what();
    }
    return {};
}

// Takes the first line out of `lines` that names the place and holds the message.
bool take_error(std::vector<std::string>& lines, const std::string& path, const std::string& expected) {
    std::string place, message = expected;
    if (!expected.empty() && std::isdigit(static_cast<unsigned char>(expected[0]))) {
        const std::size_t end = expected.find(": ");
        place = ":" + expected.substr(0, end);
        message = expected.substr(end + 2);
    }
    const auto found = std::find_if(lines.begin(), lines.end(), [&](const std::string& line) {
        return line.starts_with(path + (place.empty() ? "" : place + ": error: ")) &&
               line.find(message) != std::string::npos;
    });
    if (found == lines.end()) return false;
    lines.erase(found);
    return true;
}

class BadScene : public testing::TestWithParam<std::string> {};

TEST_P(BadScene, IsToldWhereAndWhy) {
    const std::string path = (kFolder / "bad_scenes" / (GetParam() + ".yaml")).string();
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    const std::string told = errors_of(path);
    std::vector<std::string> lines = lines_of(told);
    std::size_t expected = 0;
    for (const std::string& line : lines_of(text.str())) {
        if (line.starts_with("# expect: ")) {
            ++expected;
            EXPECT_TRUE(take_error(lines, path, line.substr(10))) << line << "\nbut told was\n" << told;
        }
        if (line.starts_with("# hint: ")) {
            EXPECT_NE(told.find(line.substr(8)), std::string::npos) << line << "\nbut told was\n" << told;
        }
    }
    EXPECT_GT(expected, 0u);
    // The first line counts the errors, and no other error is told.
    EXPECT_TRUE(told.starts_with("scene ")) << told;
    EXPECT_NE(told.find(": " + std::to_string(expected) + (expected == 1 ? " error\n" : " errors\n")),
              std::string::npos)
        << told;
}

INSTANTIATE_TEST_SUITE_P(Files, BadScene, testing::ValuesIn(bad_scenes()), [](const auto& name) { return name.param; });

TEST(SceneErrors, ShowTheLineAndACaretUnderThePlace) {
    const std::string told = errors_of_text("solver:\n  spacing: 0.1\n  suport: 2\n");
    EXPECT_EQ(told,
              "scene text.yaml: 1 error\n"
              "text.yaml:3:3: error: unknown key \"suport\" in solver\n"
              "    3 |   suport: 2\n"
              "      |   ^^^^^^ did you mean \"support\"?");
}

TEST(SceneErrors, StandInTheOrderOfTheFile) {
    const std::string told = errors_of_text("look: {output: {width: 0}}\nframes: {last: -1}\nbogus: 1\n");
    const std::size_t a = told.find("text.yaml:1:24"), b = told.find("text.yaml:2:16"), c = told.find("text.yaml:3:1");
    EXPECT_LT(a, b);
    EXPECT_LT(b, c);
    EXPECT_NE(c, std::string::npos) << told;
}

TEST(SceneErrors, AtMostFiftyAreShown) {
    std::string text = "solver:\n";
    for (int k = 0; k < 3000; ++k) text += "  key" + std::to_string(k) + ": 1\n";
    const std::string told = errors_of_text(text);
    EXPECT_NE(told.find("3000 errors"), std::string::npos);
    EXPECT_NE(told.find("... and 2950 more"), std::string::npos);
    EXPECT_LT(told.size(), 50u * 600u);
}

TEST(SceneErrors, ThroughExtendsPointIntoTheFileThatIsWrong) {
    const std::string folder = (kFolder / "scenes").string();
    const std::string told = errors_of(folder + "/pour_honey_wrong.yaml");
    EXPECT_NE(told.find(folder + "/pour_honey_wrong.yaml:3:21: error: there is no material \"beer\""),
              std::string::npos)
        << told;
    EXPECT_NE(told.find(folder + "/pour_honey_wrong.yaml:5:18: error: unknown key \"spere\""), std::string::npos)
        << told;
    // The other way round: the wrong key is in the file that is extended.
    ::setenv("THIXO_FILES", ("/no/such/folder:" + kFolder.string()).c_str(), 1);
    const std::string base = errors_of_text("extends: " + (kFolder / "bad_scenes/unknown_key.yaml").string() + "\n");
    ::unsetenv("THIXO_FILES");
    EXPECT_NE(base.find("bad_scenes/unknown_key.yaml:2:26: error: unknown key"), std::string::npos) << base;
}

TEST(SceneErrors, FilesOutsideOfTheScenesFolderAreOpenedOnlyAtTheUsersWord) {
    const std::string scene = "materials: {m: {}}\nbodies: {b: {material: m, shape: {mesh: {scale: 1, file: ";
    const auto said = [&](const std::string& file, const std::vector<std::string>& overrides = {}) {
        return errors_of_text(scene + "\"" + file + "\"}}}}\n", overrides);
    };
    const test::TemporaryFolder folder;
    write_whole(folder / "mesh.obj", "v 0 0 0\n");
    const std::string outside = (folder / "mesh.obj").string();
    EXPECT_NE(said(outside).find("text.yaml:2:58: error: "), std::string::npos) << said(outside);
    EXPECT_NE(said(outside).find("lies outside of the scene's folder"), std::string::npos);
    EXPECT_NE(said("../../../../../../.." + outside).find("lies outside"), std::string::npos);
    EXPECT_EQ(said("", {"bodies.b.shape.mesh.file=" + outside}), "") << "the user's own word";
    ::setenv("THIXO_FILES", folder.path().c_str(), 1);
    EXPECT_EQ(said(outside), "");
    EXPECT_NE(said("/etc/passwd").find("lies outside"), std::string::npos);
    ::unsetenv("THIXO_FILES");
    // A link leads where it leads.
    std::filesystem::create_symlink("/etc/passwd", folder / "link.obj");
    EXPECT_NE(errors_of_text(scene + "link.obj}}}}\n", {}, (folder / "text.yaml").string()).find("lies outside"),
              std::string::npos);
    EXPECT_EQ(errors_of_text(scene + "mesh.obj}}}}\n", {}, (folder / "text.yaml").string()), "");
}

TEST(SceneErrors, ALoopOfExtendsIsTold) {
    const std::string told = errors_of((kFolder / "scenes/loop_a.yaml").string());
    EXPECT_NE(told.find("loop_b.yaml:2:10: error: "), std::string::npos) << told;
    EXPECT_NE(told.find("extends itself"), std::string::npos) << told;
}

TEST(SceneErrors, FilesThatAreNoSceneAreRefused) {
    EXPECT_NE(errors_of((kFolder / "no_such.yaml").string()).find("there is no file"), std::string::npos);
    EXPECT_NE(errors_of(kFolder.string()).find("is a folder"), std::string::npos);
    EXPECT_NE(errors_of("").find("there is no file"), std::string::npos);
    EXPECT_NE(errors_of("/dev/zero").find("is no regular file"), std::string::npos);
    EXPECT_NE(errors_of_text("").find("the file is empty"), std::string::npos);
    EXPECT_NE(errors_of_text("---\n").find("the file is empty"), std::string::npos);
    EXPECT_NE(errors_of_text("~").find("the file is empty"), std::string::npos);
    EXPECT_NE(errors_of_text(std::string("solver: {}\n\0", 12)).find("text.yaml:2:1: error: byte 0x00"),
              std::string::npos);
    EXPECT_NE(errors_of_text("# caf\xe9\n").find("text.yaml:1:6: error: byte 0xe9"), std::string::npos);
    EXPECT_NE(errors_of_text("\x7f"
                             "ELF\x02\x01")
                  .find("error: byte"),
              std::string::npos);
    EXPECT_NE(errors_of_text("# \xed\xa0\x80 surrogate").find("error: byte 0xed"), std::string::npos);
    EXPECT_NE(errors_of_text("# \xc0\xaf too long").find("error: byte 0xc0"), std::string::npos);
}

TEST(SceneErrors, AFileThatIsTooLargeIsRefused) {
    const fs::path path = fs::path(testing::TempDir()) / "thixo_large_scene.yaml";
    std::ofstream(path) << std::string((4 << 20) + 1, '#');
    EXPECT_NE(errors_of(path.string()).find("has more than 4 MiB"), std::string::npos);
    fs::remove(path);
}

TEST(SceneErrors, NestingWithoutEndIsRefused) {
    EXPECT_NE(errors_of_text("a: " + std::string(100, '[') + std::string(100, ']')).find("nested too deep"),
              std::string::npos);
    EXPECT_FALSE(errors_of_text("a: " + std::string(100000, '[')).empty());
    EXPECT_FALSE(errors_of_text("a: " + std::string(100000, '{')).empty());
    std::string text = "shapes: {s: ";
    for (int k = 0; k < 60; ++k) text += "{union: [";
    EXPECT_NE(errors_of_text(text).find("nested too deep"), std::string::npos);
    // A chain of aliases, each nested in the next, is as deep as if it were written out.
    text = "a0: &a0 [1]\n";
    for (int k = 1; k < 200; ++k) text += fmt::format("a{}: &a{} [*a{}]\n", k, k, k - 1);
    EXPECT_NE(errors_of_text(text).find("nested too deep"), std::string::npos);
}

TEST(SceneErrors, AChainOfNamedShapesHasALimit) {
    std::string text = "shapes:\n  s0: {sphere: {radius: 1}}\n";
    for (int k = 1; k < 5000; ++k) text += fmt::format("  s{}: {{named: s{}}}\n", k, k - 1);
    EXPECT_NE(errors_of_text(text).find("nested more than 256 deep"), std::string::npos);
    text = "shapes:\n";
    for (int k = 0; k < 5000; ++k) text += fmt::format("  s{}: {{named: s{}}}\n", k, k + 1);
    text += "  s5000: {sphere: {radius: 1}}\n";
    EXPECT_NE(errors_of_text(text).find("nested more than 256 deep"), std::string::npos);
}

TEST(SceneErrors, AliasedTextIsCountedInFull) {
    std::string text = "a: &a \"" + std::string(100000, 'x') + "\"\nb: [";
    for (int k = 0; k < 1000; ++k) text += "*a, ";
    EXPECT_NE(errors_of_text(text + "1]\n").find("too much text"), std::string::npos);
}

TEST(SceneErrors, OverridesAreToldAsTyped) {
    const std::string text = "solver: {spacing: 0.1}\nmaterials: {water: {}}\n";
    const auto told = [&](const std::string& set) { return errors_of_text(text, {set}); };
    EXPECT_NE(told("solver.spacin=1").find("--set:1:8: error: unknown key \"spacin\""), std::string::npos)
        << told("solver.spacin=1");
    EXPECT_NE(told("solver.spacin=1").find("1 | solver.spacin=1"), std::string::npos) << told("solver.spacin=1");
    EXPECT_NE(told("solver.spacing=fine").find("--set:1:16: error: \"spacing\" needs a number"), std::string::npos)
        << told("solver.spacing=fine");
    EXPECT_NE(told("solver.spacing").find("an override needs a key and a value"), std::string::npos);
    EXPECT_NE(told("solver.spacing=").find("an override needs a key and a value"), std::string::npos);
    EXPECT_NE(told("=3").find("a part of the key path is empty"), std::string::npos);
    EXPECT_NE(told("solver..spacing=3").find("a part of the key path is empty"), std::string::npos);
    EXPECT_NE(told("solver.spacing.x=3").find("there is no \"x\" in the value \"0.1\""), std::string::npos);
    EXPECT_NE(told("solver.spacing=~").find("needs a number, not nothing"), std::string::npos);
    EXPECT_NE(told("solver.spacing=[1").find("--set:1:"), std::string::npos);
    EXPECT_NE(told("materials.watre.density=3").find("there is no \"watre\" in materials"), std::string::npos);
    EXPECT_NE(told("materials.watre.density=3").find("did you mean \"water\"?"), std::string::npos);
    EXPECT_NE(told("materials={oil: {density: 3}}").find("there is no \"oil\" in materials"), std::string::npos);
    EXPECT_NE(told("extends=other.yaml").find("unknown key \"extends\""), std::string::npos)
        << told("extends=other.yaml");
    EXPECT_NE(told("materials=3").find("needs a block"), std::string::npos);
}

TEST(SceneErrors, AStoredSceneMayNotReadOtherFiles) {
    EXPECT_THROW(parse_scene("extends: pour.yaml\n", (kFolder / "scenes/x.yaml").string(), {}, Files::ignore),
                 InputError);
    EXPECT_NO_THROW(parse_scene("extends: pour.yaml\n", (kFolder / "scenes/x.yaml").string(), {}, Files::check));
}

}  // namespace
}  // namespace thixo::scene
