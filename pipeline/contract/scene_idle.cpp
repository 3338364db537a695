// Keys that do nothing under the solvers of a scene.
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
    mixing(scene, lines);
    return lines;
}

}  // namespace thixo::scene
