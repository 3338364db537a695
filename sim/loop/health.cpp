#include "sim/loop/health.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "sim/space/scene_shapes.h"

namespace thixo {
namespace {

constexpr double kAbsoluteZero = -273.15, kHottest = 1e6;  // degC
constexpr const char* kTemperature = "temperature";
constexpr double kAbsurd = 10;  // in speeds of sound: no step length is meant for a faster particle

double speed(const Quad& v) {
    return std::sqrt(square(static_cast<double>(v.x)) + square(static_cast<double>(v.y)) +
                     square(static_cast<double>(v.z)));
}

/// The first quantity of particle i that is wrong, in the order in which a step computes them; null where none is.
const char* wrong_term(const Simulation& sim, std::size_t i, double fastest) {
    const Particles& p = sim.particles;
    if (!p.position[i].allFinite()) return "position";
    if (!(speed(sim.sweep.motion[i]) <= fastest)) return "velocity";
    if (!std::isfinite(p.density[i])) return "density";
    if (!std::isfinite(p.pressure[i])) return "pressure";
    if (!p.acceleration[i].allFinite()) return "acceleration";
    if (!(p.temperature[i] >= kAbsoluteZero && p.temperature[i] <= kHottest)) return kTemperature;
    return nullptr;
}

std::string likely_cause(const Simulation& sim, const StepLimits& limits, const char* term) {
    if (term == kTemperature) return "a heat source gives or takes more power than this matter can have";
    const double fixed = sim.problem.scene.solver.time_step.fixed;
    if (fixed > limits.smallest())
        return fmt::format("solver.time_step.fixed of {:.3g} s is above the {} limit of {:.3g} s", fixed,
                           limits.cause(), limits.smallest());
    if (sim.clock.step < 10) return "particles start too close to each other, or inside a wall";
    if (sim.problem.strategy.incompressible)
        return "a moving wall squeezes the fluid, or the pressure solve ends at solver.iterations (cut_off in "
               "stats.jsonl)";
    if (sim.problem.scene.solver.artificial_viscosity < 0.01)
        return "solver.artificial_viscosity is too small for an impact of this speed";
    return "a moving wall squeezes the fluid, or solver.expected_speed is too small: the fluid is too soft for this "
           "flow";
}

/// The command that runs the frame again: options stand before the scene.
std::string replay_line(const Simulation& sim) {
    const scene::Scene& scene = sim.problem.scene;
    return fmt::format("thixo sim --frames={}-{} {}", scene.frames.first, sim.clock.frame + 1,
                       sim.problem.replay.empty() ? scene.name : sim.problem.replay);
}

/// Of a body that has split off: the name of the one that it comes from.
std::string body_name(const Simulation& sim, std::int32_t id) {
    const scene::Scene& scene = sim.problem.scene;
    const auto piece = std::ranges::find(sim.solids.bodies, id, &SolidBody::id);
    const auto body =
        static_cast<std::size_t>(piece != sim.solids.bodies.end() && piece->source >= 0 ? piece->source : id);
    if (body < scene.bodies.size()) return scene.bodies[body].name;
    const std::size_t emitter = body - scene.bodies.size();
    return emitter < scene.emitters.size() ? scene.emitters[emitter].name : std::to_string(id);
}

/// The fastest particle of solids.
std::size_t fastest_solid(const Particles& p) {
    std::size_t best = 0;
    Real speed2 = -1;
    for (std::size_t i = 0; i < p.size(); ++i)
        if (is_elastic(p.phase[i]) && p.velocity[i].squaredNorm() > speed2)
            best = i, speed2 = p.velocity[i].squaredNorm();
    return best;
}

}  // namespace

void check_health(const Simulation& sim, const StepLimits& limits) {
    double sound = 0;
    for (const ResolvedMaterial& m : sim.problem.materials) sound = std::max(sound, static_cast<double>(m.sound_speed));
    const double fastest = kAbsurd * std::max(sound, sim.problem.expected_speed);
    const std::size_t n = sim.particles.size();
    const std::size_t first = parallel_reduce(
        n, n, [&](std::size_t i) { return wrong_term(sim, i, fastest) ? i : n; },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (first == n) return;
    const Vec3& x = sim.particles.position[first];
    const char* term = wrong_term(sim, first, fastest);
    throw DivergedError(
        "the simulation diverged: {} of particle {} at {} m on the way to frame {}, step {} (dt "
        "{:.3g} s, limit {:.3g} s, "
        "speed {:.3g} m/s)\nlikely: {}\nreplay: {}",
        term, sim.particles.id[first], place_text(sim.problem.scene, x), sim.clock.frame + 1, sim.clock.step,
        sim.clock.last_dt, limits.smallest(), speed(sim.sweep.motion[first]), likely_cause(sim, limits, term),
        replay_line(sim));
}

void check_solids_health(const Simulation& sim, const SolidReport& report) {
    double sound2 = 0;
    for (std::size_t b = 0; b < sim.solids.bodies.size(); ++b) {
        if (sim.solids.bodies[b].empty()) continue;
        const Index first = sim.solids.bodies[b].elements.front();
        const double density = static_cast<double>(sim.solids.elements.mass[first] / sim.solids.elements.volume[first]);
        sound2 = std::max(
            sound2,
            static_cast<double>(sim.solids.laws[b].wave_modulus() + sim.solids.laws[b].volume_stiffness) / density);
    }
    const double fastest = kAbsurd * std::max(std::sqrt(sound2), sim.problem.expected_speed);
    const Particles& p = sim.particles;
    const auto wrong = [&](std::size_t i) {
        return is_elastic(p.phase[i]) &&
               (!p.position[i].allFinite() || !(static_cast<double>(p.velocity[i].norm()) <= fastest));
    };
    const std::size_t n = p.size();
    std::size_t first = parallel_reduce(
        n, n, [&](std::size_t i) { return wrong(i) ? i : n; },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (first == n && !report.stuck) return;
    if (first == n) first = fastest_solid(p);
    const Vec3& x = p.position[first];
    throw DivergedError(
        "the simulation diverged: {} of particle {} of body '{}' at {} m on the way to frame {}, "
        "step {} (sub-step "
        "{:.3g} s, largest stretch {:.3g})\nlikely: {}\nreplay: {}",
        x.allFinite() ? "velocity" : "position", p.id[first], body_name(sim, p.body[first]),
        place_text(sim.problem.scene, x), sim.clock.frame + 1, sim.clock.step, report.smallest_dt,
        std::sqrt(sim.solids.stretch2),
        sim.solids.stretch2 > 9
            ? "the body is stretched or pressed beyond what its elastic law describes: slow the handle or the impact, "
              "raise youngs_modulus, or add volume_stiffness"
            : "a handle or a moving wall is faster than the body can follow",
        replay_line(sim));
}

}  // namespace thixo
