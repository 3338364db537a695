#include "pipeline/contract/scene_reference.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "pipeline/contract/scene_io.h"

namespace thixo::scene {
namespace {

// With THIXO_UPDATE_DOCS=1 in the environment the files are rewritten, and the test still compares.
void expect_fresh(const char* file, const std::string& text) {
    const std::string path = std::string(THIXO_SOURCE_DIR) + "/docs/" + file;
    if (const char* update = std::getenv("THIXO_UPDATE_DOCS"); update && std::string(update) == "1")
        std::ofstream(path, std::ios::binary) << text;
    std::ifstream stream(path, std::ios::binary);
    std::stringstream there;
    there << stream.rdbuf();
    EXPECT_TRUE(there.str() == text) << "docs/" << file << " is stale; run this test with THIXO_UPDATE_DOCS=1";
}

TEST(SceneReference, DocsSceneMdIsFresh) { expect_fresh("scene.md", scene_reference()); }
TEST(SceneReference, DocsSchemaIsFresh) { expect_fresh("scene.schema.json", scene_schema()); }

TEST(SceneReference, TheExampleItShowsIsAScene) {
    const std::string text = scene_reference();
    const std::size_t begin = text.find("```yaml\n") + 8, end = text.find("```", begin);
    EXPECT_TRUE(scene_warnings(parse_scene(text.substr(begin, end - begin), "example.yaml")).empty());
}

// Every top-level key of a printed block is a property of its schema.
void expect_known(const nlohmann::json& schema, const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == ' ') continue;
        EXPECT_TRUE(schema.at("properties").contains(line.substr(0, line.find(':')))) << line;
    }
}

TEST(SceneReference, TheSchemaKnowsEveryBlockOfAPrintedScene) {
    const nlohmann::json schema = nlohmann::json::parse(scene_schema());
    expect_known(schema, print_scene(Scene{}));
    expect_known(schema.at("properties").at("look"), print_look(Look{}));
    EXPECT_EQ(schema.at("properties").at("solver").at("properties").at("spacing").at("default"), 0.01);
    EXPECT_EQ(schema.at("properties").at("solver").at("properties").at("spacing").at("minimum"), 1e-6);
    EXPECT_EQ(schema.at("$defs").at("shape").at("oneOf").size(), 21u);  // 20 kinds, or none
}

}  // namespace
}  // namespace thixo::scene
