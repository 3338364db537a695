#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "pipeline/base/error.h"
#include "pipeline/contract/hash.h"
#include "pipeline/contract/image.h"
#include "pipeline/contract/scene_check.h"
#include "pipeline/contract/scene_walk.h"

namespace thixo::scene {
namespace {

std::optional<std::string> hash_of_file(const std::string& path) {
    std::error_code failure;
    if (!std::filesystem::is_regular_file(path, failure)) return std::nullopt;
    std::ifstream file(path, std::ios::binary);
    std::ostringstream bytes;
    if (!file.is_open() || (file.peek() != std::ifstream::traits_type::eof() && !(bytes << file.rdbuf())))
        return std::nullopt;
    return hash_hex(bytes.view());
}

}  // namespace

void read_file_hashes(Scene& scene, ReadContext& context) {
    std::map<std::string, std::optional<std::string>> hashes;  // each file is read once
    const auto fill = [&](const std::string& file, std::string& content, const std::string& path, const char* kind) {
        if (file.empty() || context.closed.contains(file)) return;
        const auto [entry, added] = hashes.try_emplace(file);
        if (added) entry->second = hash_of_file(file);
        const std::optional<std::string>& hash = entry->second;
        const auto at = [&](const char* key) {
            const auto found = context.where.find(path + key);
            return found == context.where.end() ? Position{} : found->second;
        };
        if (!hash)
            context.problems.add(at(".file"), fmt::format("there is no {} file {}", kind, shown(file, kPathShown)));
        else if (!content.empty() && content != *hash)
            context.problems.add(at(".content"), fmt::format("the {} file {} has changed: its content is {}", kind,
                                                             shown(file, kPathShown), *hash));
        else
            content = *hash;
    };
    walk_shapes(scene, [&](Shape& shape, const std::string& path) {
        if (MeshFile* mesh = std::get_if<MeshFile>(&shape.kind))
            fill(mesh->file, mesh->content, path + ".mesh", "mesh");
    });
    for (Body& b : scene.bodies)
        for (std::size_t k = 0; k < b.cracks.size(); ++k) {
            CrackImage& image = b.cracks[k].image;
            const std::string path = fmt::format("bodies.{}.cracks.{}.image", b.name, k);
            const auto found = context.where.find(path + ".file");
            fill(image.file, image.content, path, "image");
            if (image.content.empty()) continue;
            try {
                read_png(image.file);
            } catch (const CacheError& e) {  // a picture that a user names is input
                context.problems.add(found == context.where.end() ? Position{} : found->second, e.what());
            }
        }
}

}  // namespace thixo::scene
