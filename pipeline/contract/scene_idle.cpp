// Keys that do nothing in a scene: under its solvers, and beside the words that others have.
#include <fmt/format.h>

#include <algorithm>

#include "pipeline/contract/scene_io.h"

namespace thixo::scene {
namespace {

using Lines = std::vector<std::string>;

template <class T>
void tell_if_set(const T& value, const T& by_default, const std::string& key, const char* why, Lines& lines) {
    if (value != by_default) lines.push_back(fmt::format("{} does nothing {}", key, why));
}

void idle_of_pressure(const Scene& scene, Lines& lines) {
    const Solver &s = scene.solver, by_default;
    const Material plain;
    if (s.pressure == Pressure::dfsph) {
        constexpr const char* kWhy = "with `pressure: dfsph`";
        tell_if_set(s.artificial_viscosity, by_default.artificial_viscosity, "solver.artificial_viscosity", kWhy,
                    lines);
        for (const Material& m : scene.materials) {
            tell_if_set(m.stiffness, plain.stiffness, "materials." + m.name + ".stiffness", kWhy, lines);
            tell_if_set(m.gamma, plain.gamma, "materials." + m.name + ".gamma", kWhy, lines);
        }
        return;
    }
    constexpr const char* kWhy = "without `pressure: dfsph`";
    tell_if_set(s.density_tolerance, by_default.density_tolerance, "solver.density_tolerance", kWhy, lines);
    tell_if_set(s.divergence_tolerance, by_default.divergence_tolerance, "solver.divergence_tolerance", kWhy, lines);
    tell_if_set(s.iterations, by_default.iterations, "solver.iterations", kWhy, lines);
}

void idle_of_steps(const Scene& scene, Lines& lines) {
    const Solver &s = scene.solver, by_default;
    if (s.viscosity == Viscosity::explicit_force)
        tell_if_set(s.viscosity_tolerance, by_default.viscosity_tolerance, "solver.viscosity_tolerance",
                    "with `viscosity: explicit`", lines);
    if (s.solids == SolidSteps::leapfrog)
        tell_if_set(s.solids_tolerance, by_default.solids_tolerance, "solver.solids_tolerance",
                    "without `solids: implicit`", lines);
    if (s.time_step.fixed > 0) {
        constexpr const char* kWhy = "with `time_step: {fixed: ...}`";
        tell_if_set(s.time_step.maximum, by_default.time_step.maximum, "solver.time_step.maximum", kWhy, lines);
        tell_if_set(s.time_step.cfl, by_default.time_step.cfl, "solver.time_step.cfl", kWhy, lines);
    }
}

/// Plastic keys of a material that never flows, and of which no other takes values over.
void idle_of_plasticity(const Scene& scene, Lines& lines) {
    const Elastic by_default;
    for (const Material& m : scene.materials) {
        const Elastic& e = m.elastic;
        if (e.creep > 0 || m.melting.any() || !e.changes.empty()) continue;
        constexpr const char* kWhy = "without `creep`";
        const std::string at = "materials." + m.name + ".";
        tell_if_set(e.yield_strain, by_default.yield_strain, at + "yield_strain", kWhy, lines);
        tell_if_set(e.hardening, by_default.hardening, at + "hardening", kWhy, lines);
        tell_if_set(e.maximum_plastic_strain, by_default.maximum_plastic_strain, at + "maximum_plastic_strain", kWhy,
                    lines);
        tell_if_set(e.flow, by_default.flow, at + "flow", kWhy, lines);
    }
}

/// Without a surface there is nothing that bounds what has frozen (docs/fracture.md).
void idle_of_frozen(const Scene& scene, Lines& lines) {
    for (const Material& m : scene.materials)
        if (m.fracture.any() && m.melting.any() && !scene.surface.enabled)
            lines.push_back(fmt::format(
                "materials.{}.fracture does nothing in matter that has melted and frozen, without a surface", m.name));
}

/// Keys that a probe's measure does not read.
void idle_of_probes(const Scene& scene, Lines& lines) {
    const Probe plain;
    for (const Probe& p : scene.probes) {
        using enum Measure;
        const auto is = [&](std::initializer_list<Measure> list) {
            return std::ranges::find(list, p.measure) != list.end();
        };
        const auto tell = [&](bool read, const auto& value, const auto& by_default, const char* key) {
            const std::string why =
                fmt::format("with `measure: {}`", Words<Measure>::list[static_cast<std::size_t>(p.measure)]);
            if (!read) tell_if_set(value, by_default, fmt::format("probes.{}.{}", p.name, key), why.c_str(), lines);
        };
        const bool of_quantity = is({point, mean, total, follow});
        const bool turns = of_quantity && (p.quantity == Quantity::angular_x || p.quantity == Quantity::angular_y ||
                                           p.quantity == Quantity::angular_z);
        tell(of_quantity, p.quantity, plain.quantity, "quantity");
        tell(!is({bodies, crack_area, fronts}), p.material, plain.material, "material");
        tell(is({mean, total, extent, follow, wall_force}), p.region.kind.index(), plain.region.kind.index(), "region");
        tell(is({point, follow, flux, wall_pressure}) || turns, p.position, plain.position, "position");
        tell(is({extent, flux, wall_force, wall_pressure}), p.direction, plain.direction, "direction");
        tell(is({flux, wall_pressure}), p.radius, plain.radius, "radius");
        tell(is({extent}), p.quantile, plain.quantile, "quantile");
        if (!is({wall_force, wall_pressure})) continue;
        if (scene.world.boundaries.empty())
            lines.push_back(fmt::format("probes.{} measures what presses on walls, and there is none", p.name));
        for (const Material& m : scene.materials)
            if (m.name == p.material && m.elastic.solid() && !m.melting.any())
                lines.push_back(
                    fmt::format("probes.{} measures liquids; the contact of solids is not counted", p.name));
    }
}

/// Keys that a light's type does not read.
void idle_of_lights(const Scene& scene, Lines& lines) {
    const Light plain;
    for (const Light& l : scene.look.lights) {
        using enum LightType;
        const auto tell = [&](std::initializer_list<LightType> readers, const auto& value, const auto& by_default,
                              const char* key) {
            if (std::ranges::find(readers, l.type) != readers.end()) return;
            const std::string why =
                fmt::format("with `type: {}`", Words<LightType>::list[static_cast<std::size_t>(l.type)]);
            tell_if_set(value, by_default, fmt::format("look.lights.{}.{}", l.name, key), why.c_str(), lines);
        };
        const Vec3d down = light_direction(plain);
        tell({sun, area, spot}, l.direction.value_or(down), down, "direction");
        tell({area, spot}, l.look_at, plain.look_at, "look_at");
        tell({sun}, l.angle, plain.angle, "angle");
        tell({spot}, l.cone, plain.cone, "cone");
        tell({spot}, l.softness, plain.softness, "softness");
        tell({area, point, spot}, l.position, plain.position, "position");
        tell({area}, l.size, plain.size, "size");
        tell({sky}, l.horizon, plain.horizon, "horizon");
        tell({sky}, l.ground, plain.ground, "ground");
        tell({environment}, l.file, plain.file, "file");
        tell({environment}, l.rotation, plain.rotation, "rotation");
        const bool sizeless = l.type == point || l.type == spot;
        const auto dims = [&](const Appearance& a) {
            return a.type == AppearanceType::dielectric && (a.roughness > 0 || !scene.look.output.straight_shadows);
        };
        for (const Appearance& a : scene.look.appearances)
            if (sizeless && dims(a))
                lines.push_back(
                    fmt::format("look.lights.{} has no size: it does not shine through '{}', which is rough or has no "
                                "straight_shadows; a small area light does",
                                l.name, a.name));
    }
}

/// Keys of a glow without strength.
void idle_of_glow(const Scene& scene, Lines& lines) {
    const Glow plain;
    for (const Appearance& a : scene.look.appearances) {
        if (glows(a)) continue;
        const std::string at = "look.appearances." + a.name + ".glow.";
        tell_if_set(a.glow.colour, plain.colour, at + "colour", "without `strength`", lines);
        tell_if_set(a.glow.black_body, plain.black_body, at + "black_body", "without `strength`", lines);
    }
}

void idle_of_camera(const Scene& scene, Lines& lines) {
    const Camera &c = scene.look.camera, plain;
    if (c.path.empty()) return;
    tell_if_set(c.position, plain.position, "look.camera.position", "beside a path", lines);
    tell_if_set(c.look_at, plain.look_at, "look.camera.look_at", "beside a path", lines);
}

/// Artificial viscosity is what keeps particles of the `eos` solver from wandering.
void mixing(const Scene& scene, Lines& lines) {
    constexpr double kCalm = 0.05;
    const Solver& s = scene.solver;
    if (s.pressure != Pressure::eos || s.artificial_viscosity >= kCalm) return;
    std::vector<double> densities;
    for (const Material& m : scene.materials)
        if (!m.elastic.solid()) densities.push_back(m.density);
    if (densities.empty() || std::ranges::max(densities) == std::ranges::min(densities)) return;
    lines.push_back(
        fmt::format("solver.artificial_viscosity {} is so small that liquids of different density mix with `pressure: "
                    "eos`; {} keeps them apart",
                    s.artificial_viscosity, Solver().artificial_viscosity));
}

}  // namespace

std::vector<std::string> idle_keys(const Scene& scene) {
    Lines lines;
    idle_of_pressure(scene, lines);
    idle_of_steps(scene, lines);
    idle_of_plasticity(scene, lines);
    idle_of_frozen(scene, lines);
    idle_of_probes(scene, lines);
    idle_of_lights(scene, lines);
    idle_of_glow(scene, lines);
    idle_of_camera(scene, lines);
    mixing(scene, lines);
    return lines;
}

}  // namespace thixo::scene
