// Scenes damaged at random, with a fixed seed: each is read or refused with an InputError, in bounded time, and nothing
// else happens.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/contract/picture_cost.h"
#include "pipeline/contract/scene_io.h"
#include "tests/pipeline/contract/cache_fixture.h"
#include "tests/pipeline/contract/mutated.h"

namespace thixo::scene {
namespace {

namespace fs = std::filesystem;

std::string read(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

std::vector<std::string> seeds() {
    const fs::path folder = fs::path(THIXO_SOURCE_DIR) / "tests/pipeline/contract";
    std::vector<fs::path> files;
    for (const char* sub : {"bad_scenes", "scenes"})
        for (const auto& entry : fs::directory_iterator(folder / sub)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<std::string> texts;
    for (const fs::path& file : files)
        if (file.stem() != "laughs" && file.stem() != "exploding_shapes")
            texts.push_back(read(file));  // slow by design
    return texts;
}

const std::vector<std::string> kPieces = {"[",  "]",     "{", "}",    ": ",          "- ",   "\n",    "  ",
                                          "\t", "\"",    "'", "#",    "&a ",         "*a",   "!x ",   "|",
                                          ">",  "---\n", "~", "<<: ", "0",           "-",    "1e999", ".nan",
                                          "é",  "\xff",  "?", ", ",   "%YAML 1.2\n", "\r\n", "null",  "...\n"};

std::string damaged(std::string text, const std::vector<std::string>& others, std::uint64_t id) {
    const int edits = 1 + static_cast<int>(random_bits(1, id, 0, 0) % 4);
    for (int k = 1; k <= edits; ++k) {
        const auto pick = [&](std::uint64_t use, std::size_t n) {
            return n ? static_cast<std::size_t>(random_bits(1, id, static_cast<std::uint64_t>(k), use) % n) : 0;
        };
        const std::size_t at = pick(1, text.size() + 1), length = pick(2, 30);
        switch (pick(0, 5)) {
            case 0:
                text.insert(at, kPieces[pick(3, kPieces.size())]);
                break;
            case 1:
                text.erase(std::min(at, text.size()), length);
                break;
            case 2:
                text.insert(at, text.substr(pick(3, text.size() + 1), length));
                break;
            case 3:
                if (at < text.size()) text[at] = static_cast<char>(pick(3, 256));
                break;
            default: {
                const std::string& other = others[pick(3, others.size())];
                text.insert(at, other.substr(pick(4, other.size() + 1), 10 * length));
            }
        }
    }
    return text;
}

TEST(SceneFuzz, DamagedScenesAreReadOrRefused) {
    const std::vector<std::string> texts = seeds();
    const std::string sound = read(fs::path(THIXO_SOURCE_DIR) / "tests/pipeline/contract/scenes/pour.yaml");
    const std::uint64_t rounds = test::fuzz_rounds(10'000);
    std::uint64_t accepted = 0, refused = 0;
    for (std::uint64_t id = 0; id < rounds; ++id) {
        const std::string text = damaged(id % 2 ? sound : texts[id / 2 % texts.size()], texts, id);
        try {
            const Scene scene = parse_scene(text, "fuzz.yaml", {}, Files::ignore);
            // An accepted scene can be printed and is accepted again.
            const std::string printed = print_scene(scene);
            EXPECT_EQ(print_scene(parse_scene(printed, "again.yaml", {}, Files::ignore)), printed) << text;
            ++accepted;
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find("error"), std::string::npos);
            ++refused;
        }
    }
    EXPECT_GT(accepted, rounds / 100);  // the damage is not always fatal, or the test would test little
    EXPECT_GT(refused, rounds / 10);
}

TEST(SceneFuzz, ChangedLooksAreReadOrRefused) {
    const test::TemporaryFolder folder;
    const Scene base = load_scene(THIXO_SOURCE_DIR "/tests/faults/lights.yaml");
    const std::string look = print_look(base.look), file = (folder / "look.yaml").string();
    const std::uint64_t rounds = test::fuzz_rounds(1000);
    std::uint64_t accepted = 0, refused = 0;
    ::setenv("THIXO_FILES", THIXO_SOURCE_DIR, 1);  // the look calls its image by its whole path
    for (std::uint64_t k = 0; k < rounds; ++k) {
        std::ofstream(file, std::ios::binary) << (k % 3 == 0 ? test::mutated : test::with_other_numbers)(look, 1, k);
        try {
            const Look changed = overlay_look(base.look, file);
            EXPECT_GE(picture_cost(changed, nullptr).memory, 0);
            EXPECT_FALSE(print_look(changed).empty());
            ++accepted;
        } catch (const InputError&) {
            ++refused;
        }
    }
    ::unsetenv("THIXO_FILES");
    EXPECT_GT(accepted, rounds / 20);
    EXPECT_GT(refused, rounds / 20);
}

TEST(SceneFuzz, DamagedOverridesAreReadOrRefused) {
    const std::string text = read(fs::path(THIXO_SOURCE_DIR) / "tests/pipeline/contract/scenes/pour.yaml");
    const std::vector<std::string> sets = {"solver.spacing=0.1", "look.camera.position=[1, 2, 3]",
                                           "world.boundaries.glass.motion.1.time=2", "materials.water={density: 3}"};
    for (std::uint64_t id = 0; id < 1500; ++id) {
        try {
            parse_scene(text, "fuzz.yaml", {damaged(sets[id % sets.size()], sets, id)}, Files::ignore);
        } catch (const InputError&) {
        }
    }
}

}  // namespace
}  // namespace thixo::scene
