#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "pipeline/contract/hash.h"
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

void read_mesh_hashes(Scene& scene, ReadContext& context) {
    std::map<std::string, std::optional<std::string>> hashes;  // each file is read once
    walk_shapes(scene, [&](Shape& shape, const std::string& path) {
        MeshFile* mesh = std::get_if<MeshFile>(&shape.kind);
        if (!mesh || mesh->file.empty() || context.closed.contains(mesh->file)) return;
        const auto [entry, added] = hashes.try_emplace(mesh->file);
        if (added) entry->second = hash_of_file(mesh->file);
        const std::optional<std::string>& hash = entry->second;
        const auto at = [&](const char* key) {
            const auto found = context.where.find(path + ".mesh." + key);
            return found == context.where.end() ? Position{} : found->second;
        };
        if (!hash)
            context.problems.add(at("file"), fmt::format("there is no mesh file {}", shown(mesh->file, kPathShown)));
        else if (!mesh->content.empty() && mesh->content != *hash)
            context.problems.add(at("content"), fmt::format("the mesh file {} has changed: its content is {}",
                                                            shown(mesh->file, kPathShown), *hash));
        else
            mesh->content = *hash;
    });
}

}  // namespace thixo::scene
