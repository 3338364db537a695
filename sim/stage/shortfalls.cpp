#include "sim/stage/shortfalls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pipeline/base/parallel.h"
#include "sim/loop/time_step.h"
#include "sim/sources/emitter.h"

namespace thixo {
namespace {

using List = std::vector<Shortfall>;

void add(Lack lack, std::string name, std::int64_t count, std::int64_t of, double worst, List& list) {
    if (count > 0) merge_shortfalls({{lack, std::move(name), count, of, worst}}, list);
}

void add_blocked(const Simulation& sim, List& list) {
    for (std::size_t e = 0; e < sim.emitters.size(); ++e)
        add(Lack::blocked, sim.problem.scene.emitters[e].name, sim.emitters[e].blocked, sim.emitters[e].due, 0, list);
}

void add_cut_off(const Simulation& sim, List& list) {
    const StepStats& t = sim.stats;
    add(Lack::cut_off, "density", t.density.cut_off, t.density.solves, t.density.residual, list);
    add(Lack::cut_off, "divergence", t.divergence.cut_off, t.divergence.solves, t.divergence.residual, list);
    add(Lack::cut_off, "viscosity", t.viscosity_unconverged, t.steps, t.viscosity_residual, list);
    add(Lack::cut_off, "implicit solids", t.solid_unconverged, t.solid_sub_steps, 0, list);
}

void add_walls(const Simulation& sim, List& list) {
    add(Lack::passed, "", sim.stats.passed_walls, 0, 0, list);
    const Particles& p = sim.particles;
    const Real deep = -sim.problem.smoothing.spacing / 2;
    const auto inside = static_cast<std::int64_t>(parallel_sum(
        p.size(), [&](std::size_t i) { return wall_distance(sim.walls, p.position[i]) < deep ? 1.0 : 0.0; }));
    add(Lack::inside, "", inside, static_cast<std::int64_t>(p.size()), 0, list);
}

/// Solids say how much denser than at rest their particles are (write_particles).
void add_crushed(const Simulation& sim, List& list) {
    if (sim.solids.empty()) return;
    const Particles& p = sim.particles;
    const std::vector<scene::Body>& bodies = sim.problem.scene.bodies;
    std::vector<std::int64_t> crushed(bodies.size(), 0), all(bodies.size(), 0);
    for (const SolidBody& body : sim.solids.bodies) {
        if (!body.shaped()) continue;
        const auto source = static_cast<std::size_t>(body.source);
        for (const Index e : body.elements) {
            const std::size_t i = sim.solids.particle_of[e];
            if (p.phase[i] != Phase::solid) continue;
            ++all[source];
            if (p.density[i] * p.rest_volume[i] > 2 * p.mass[i]) ++crushed[source];
        }
    }
    for (std::size_t b = 0; b < bodies.size(); ++b) add(Lack::crushed, bodies[b].name, crushed[b], all[b], 0, list);
}

/// Of each body, by id, whether it is liquid. Of one that has melted in part the surfels are still those of the solid, as
/// dense as the scene says.
std::vector<std::uint8_t> liquid_bodies(const Particles& p) {
    constexpr double kMelted = 0.9;  // of its particles
    std::vector<std::array<double, 2>> count;
    for (std::size_t i = 0; i < p.size(); ++i) {
        const auto body = static_cast<std::size_t>(p.body[i]);
        if (body >= count.size()) count.resize(body + 1, {0, 0});
        count[body][0] += 1;
        if (p.phase[i] != Phase::solid) count[body][1] += 1;
    }
    std::vector<std::uint8_t> liquid;
    for (const auto& [all, melted] : count) liquid.push_back(all > 0 && melted >= kMelted * all);
    return liquid;
}

/// Films run away on walls: the liquid lies there in single particles, each with surfels all about it. So it does in a
/// thin jet or a spray, which are as the scene says. A few particles are a splash, and cost little.
void add_runaway(const Simulation& sim, List& list) {
    constexpr double kFewest = 500;  // particles
    const SurfaceState& surface = sim.solids.empty() ? sim.surface : sim.mixed_surface.animated;
    if (surface.size() == 0 || sim.walls.list.empty()) return;
    const Particles& p = sim.particles;
    const std::vector<std::uint8_t> liquid = liquid_bodies(p);
    const auto counts = [&](std::int32_t body) {
        return static_cast<std::size_t>(body) < liquid.size() && liquid[static_cast<std::size_t>(body)];
    };
    const Real near = Real(1.5) * sim.problem.smoothing.spacing;
    const auto count = [&](const std::vector<Vec3>& place, const std::vector<std::int32_t>& body, Real within) {
        return parallel_sum(place.size(), [&](std::size_t i) {
            return counts(body[i]) && wall_distance(sim.walls, place[i]) < within ? 1.0 : 0.0;
        });
    };
    const std::vector<Vec3>& surfels = surface.surfels.position;
    const double films = count(surfels, surface.body, near), particles = count(p.position, p.body, near);
    const double all = count(surfels, surface.body, std::numeric_limits<Real>::max());
    if (films > kMostSurfels * particles && particles >= kFewest && films > all / 2)
        add(Lack::runaway, "", static_cast<std::int64_t>(films), static_cast<std::int64_t>(particles), 0, list);
}

}  // namespace

List find_shortfalls(const Simulation& sim) {
    List list;
    add_blocked(sim, list);
    add_cut_off(sim, list);
    add_walls(sim, list);
    add_crushed(sim, list);
    add_runaway(sim, list);
    add(Lack::long_step, sim.stats.overstepped, sim.stats.long_steps, sim.stats.steps, sim.stats.overstep, list);
    return list;
}

List expect_shortfalls(const Simulation& sim) {
    List list;
    const scene::Scene& scene = sim.problem.scene;
    for (std::size_t e = 0; e < scene.emitters.size(); ++e) {
        const OpeningRoom room = room_at_opening(sources_of(sim), e, scene.emitters[e].start);
        add(Lack::blocked, scene.emitters[e].name, room.blocked, room.sites, 0, list);
    }
    const scene::TimeStep& params = scene.solver.time_step;
    const StepLimits limits =
        step_limits(Particles{}, Sweep{}, sim.problem.materials, sim.problem.smoothing, params, 0);
    const double limit = std::min(limits.signal, limits.viscosity);
    if (params.fixed > limit) {
        const double end = (scene.frames.last - scene.frames.first) / scene.frames.fps;
        const auto steps = static_cast<std::int64_t>(std::ceil(end / params.fixed));
        add(Lack::long_step, limit == limits.signal ? "signal" : "viscosity", steps, steps, params.fixed / limit, list);
    }
    return list;
}

}  // namespace thixo
