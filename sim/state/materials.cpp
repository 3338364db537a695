#include "sim/state/materials.h"

#include <cmath>

namespace thixo {
namespace {
constexpr Real kSoundPerSpeed = 10;
}

Real stiffness_for(Real speed, Real density, Real gamma) { return square(kSoundPerSpeed * speed) * density / gamma; }

std::vector<MaterialParams> resolve_materials(const std::vector<scene::Material>& materials, Real expected_speed,
                                              const Strategy& strategy) {
    std::vector<MaterialParams> resolved;
    for (const scene::Material& m : materials) {
        MaterialParams p{};
        p.density = static_cast<Real>(m.density);
        p.viscosity = static_cast<Real>(m.viscosity);
        p.gamma = static_cast<Real>(m.gamma);
        p.stiffness = strategy.incompressible ? Real(0)
                      : m.stiffness > 0       ? static_cast<Real>(m.stiffness)
                                              : stiffness_for(expected_speed, p.density, p.gamma);
        p.sound_speed = std::sqrt(p.stiffness * p.gamma / p.density);
        resolved.push_back(p);
    }
    return resolved;
}

}  // namespace thixo
