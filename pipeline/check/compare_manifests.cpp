#include "pipeline/check/compare_manifests.h"

#include <fmt/format.h>

namespace thixo {

// Each structured binding names all fields of its struct. A field that is added therefore fails to compile here until
// it is compared or left out on purpose.

std::vector<std::string> manifest_notes(const Manifest& a, const Manifest& b) {
    [[maybe_unused]] const auto& [format, scene, simulation_hash, complete, scene_text, assets, frames] = a;
    std::vector<std::string> notes;
    if (scene != b.scene) notes.push_back(fmt::format("the scene is '{}', the reference's '{}'", scene, b.scene));
    if (simulation_hash != b.simulation_hash) notes.emplace_back("the two were simulated with different settings");
    if (scene_text != b.scene_text) notes.emplace_back("the resolved scenes differ");
    if (complete != b.complete)
        notes.emplace_back(complete ? "the reference's simulation has not reached its last frame"
                                    : "the simulation has not reached its last frame, the reference's has");
    return notes;
}

std::vector<std::string> compare_entries(const ManifestFrame& a, const ManifestFrame& b) {
    [[maybe_unused]] const auto& [number, time, particles, surfels, particle_file, surfel_file, facts_file] = a;
    std::vector<std::string> problems;
    if (time != b.time) problems.push_back(fmt::format("the manifest's time is {}, the reference's {}", time, b.time));
    return problems;
}

}  // namespace thixo
