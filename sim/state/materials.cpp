#include "sim/state/materials.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"

namespace thixo {
namespace {

constexpr Real kSoundPerSpeed = 10;

/// The elastic values of a material in the course of time.
std::vector<ElasticValues> course_of(const scene::Scene& scene, const scene::Material& m) {
    std::vector<ElasticValues> course{{.elastic = m.elastic, .viscosity = m.viscosity}};
    for (const scene::MaterialChange& c : m.elastic.changes) {
        const auto other = std::ranges::find(scene.materials, c.material, &scene::Material::name);
        THIXO_ASSERT(other != scene.materials.end(), "no material {}", c.material);
        course.push_back({c.time, c.duration, other->elastic, other->viscosity});
    }
    for (ElasticValues& values : course) values.elastic.changes.clear();
    return course;
}

/// The viscosity of a material as a liquid. That of a solid damps its vibrations; liquids have none of it.
double liquid_viscosity(const scene::Scene& scene, const scene::Material& m) {
    if (m.melting.any()) return m.melting.liquid.viscosity;
    const bool flows =
        !m.elastic.solid() || std::ranges::any_of(scene.emitters, [&](const auto& e) { return e.material == m.name; });
    return flows ? m.viscosity : 0;
}

}  // namespace

Real stiffness_for(Real speed, Real density, Real gamma) { return square(kSoundPerSpeed * speed) * density / gamma; }

Materials resolve_materials(const scene::Scene& scene, Real expected_speed, const Strategy& strategy) {
    Materials resolved;
    for (const scene::Material& m : scene.materials) {
        ResolvedMaterial r;
        r.density = static_cast<Real>(m.density);
        r.viscosity = static_cast<Real>(liquid_viscosity(scene, m));
        r.gamma = static_cast<Real>(m.gamma);
        r.stiffness = strategy.incompressible ? Real(0)
                      : m.stiffness > 0       ? static_cast<Real>(m.stiffness)
                                              : stiffness_for(expected_speed, r.density, r.gamma);
        r.sound_speed = std::sqrt(r.stiffness * r.gamma / r.density);
        r.tension = static_cast<Real>(m.melting.any() ? m.melting.liquid.surface_tension : m.surface_tension);
        r.elastic = course_of(scene, m);
        r.fracture = m.fracture;
        r.melting = m.melting;
        r.thermal = m.thermal;
        resolved.push_back(std::move(r));
    }
    return resolved;
}

}  // namespace thixo
