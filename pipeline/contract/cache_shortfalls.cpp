#include "pipeline/contract/cache_shortfalls.h"

#include <algorithm>
#include <cmath>

#include "pipeline/contract/scene_io.h"

namespace thixo {
namespace {

constexpr double kIntegration = 0.1;  // of the largest kinetic energy
constexpr double kSettling = 0.02;    // of the matter's size
constexpr double kRounding = 1e-6;    // of the matter's size, in a frame

bool is_driven(const scene::Scene& scene) {
    const auto along_gravity = [&](const scene::PeriodicAxis& p) {
        return scene.world.gravity[static_cast<Eigen::Index>(p.axis)] != 0;
    };
    const auto moves = [](const auto& part) { return part.motion.size() > 1; };
    return !scene.emitters.empty() || std::ranges::any_of(scene.world.boundaries, moves) ||
           std::ranges::any_of(scene.handles, [&](const scene::Handle& h) { return moves(h) || !h.force.isZero(); }) ||
           std::ranges::any_of(scene.materials, [](const scene::Material& m) { return !m.elastic.changes.empty(); }) ||
           std::ranges::any_of(scene.world.periodic, along_gravity);
}

double strongest_tension(const scene::Scene& scene) {
    double strongest = 0;
    for (const scene::Material& m : scene.materials)
        strongest = std::max({strongest, m.surface_tension, m.melting.any() ? m.melting.liquid.surface_tension : 0});
    return strongest;
}

/// The gain of each frame over the first, and what of it may be.
class EnergyWatch {
  public:
    explicit EnergyWatch(const scene::Scene& scene)
        : gravity_(scene.world.gravity.norm()),
          tension_(strongest_tension(scene)),
          fps_(scene.frames.fps),
          watches_(!is_driven(scene)) {}

    void see(const Frame& frame) {
        const FrameTotals& t = frame.totals;
        const double energy = t.kinetic_energy + t.potential_energy;
        if (frames_++ == 0) at_start_ = energy;
        most_kinetic_ = std::max(most_kinetic_, t.kinetic_energy);
        const double size = std::cbrt(t.particle_volume), settling = std::max(frame.spacing, kSettling * size);
        const double creeping = kRounding * size * fps_;
        const double allowed = kIntegration * most_kinetic_ + 6 * tension_ * t.particle_volume / frame.spacing +
                               t.mass * (gravity_ * settling + creeping * creeping / 2);
        const double gain = energy - at_start_;
        if (!watches_ || !(gain > allowed)) return;
        ++seen_;
        largest_ = std::max(largest_, gain);
    }
    std::vector<Shortfall> found() const {
        if (seen_ == 0) return {};
        return {{.lack = Lack::energy, .name = "", .count = seen_, .of = frames_, .worst = largest_}};
    }

  private:
    double gravity_, tension_, fps_;
    bool watches_;
    double at_start_ = 0, most_kinetic_ = 0, largest_ = 0;
    std::int64_t frames_ = 0, seen_ = 0;
};

}  // namespace

std::vector<Shortfall> shortfalls_of(const CacheReader& reader) {
    const std::string manifest = (reader.folder() / kManifestName).string();
    EnergyWatch energy(scene::parse_cached_scene(reader.scene_text(), manifest));
    std::vector<Shortfall> list;
    for (const ManifestFrame& f : reader.manifest().frames) {
        const Frame facts = reader.load_facts(f.number);
        merge_shortfalls(facts.shortfalls, list);
        energy.see(facts);
    }
    merge_shortfalls(energy.found(), list);
    return list;
}

}  // namespace thixo
