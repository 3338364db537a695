#include "sim/loop/step.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "sim/bonds/members.h"
#include "sim/liquid/density.h"
#include "sim/liquid/forces.h"
#include "sim/liquid/leapfrog.h"
#include "sim/liquid/spin.h"
#include "sim/liquid/viscous_pairs.h"
#include "sim/loop/coupling.h"
#include "sim/loop/health.h"
#include "sim/loop/plan.h"
#include "sim/loop/time_step.h"
#include "sim/phase/phases.h"

namespace thixo {
namespace {

bool incompressible(const Simulation& sim) { return sim.problem.strategy.incompressible; }

// The least distance of a particle from a wall [m]. Pressure holds the first layer half a spacing off. This catches
// what no pressure holds: single drops, and what an impact presses on. The implicit solver's walls hold particles by
// themselves, some nearer than that. To move these back would thrust them among their neighbours.
Real least_wall_distance(const Simulation& sim) {
    return (incompressible(sim) ? Real(0.2) : Real(0.45)) * sim.problem.smoothing.spacing;
}

void sort_particles(Simulation& sim) {
    const std::vector<Index> order =
        PointGrid::sort_order(sim.particles.position, sim.particles.id, sim.problem.smoothing.support);
    reorder_table(sim.particles, order, sim.reorder_scratch);
    locate_particles(sim.particles, sim.solids);
}

void find_neighbours(Simulation& sim) {
    ScopedTimer timer(sim.stats.neighbours_seconds);
    sort_particles(sim);
    const Real support = sim.problem.smoothing.support;
    find_ghosts(sim.problem.periodic, sim.particles.position, support, sim.sweep.ghosts);
    if (sim.problem.periodic.any()) {
        append_ghosts(sim.sweep.ghosts, sim.particles.position, sim.places);
        sim.grid.build(sim.places, support);
    } else {
        sim.grid.build(sim.particles.position, support);
    }
    sim.neighbours.build(sim.grid, support, sim.particles.size());
}

/// Sorts the particles, builds the grid and finds v(t). For steps in which nothing asks for neighbours, but for those
/// at rest.
void place_solids(Simulation& sim) {
    sort_particles(sim);
    find_ghosts(sim.problem.periodic, sim.particles.position, sim.problem.smoothing.support, sim.sweep.ghosts);
    sim.grid.build(sim.particles.position, sim.problem.smoothing.support);
    pack_motion(sim.particles, 0, false, sim.sweep);
}

/// Packs what heat conduction reads, in steps without a liquid whose density is asked for.
void pack_still(Simulation& sim) {
    pack_motion(sim.particles, 0, false, sim.sweep);
    find_wall_effects(sim.walls, sim.particles.position, sim.sweep.walls);
    parallel_for(
        sim.particles.size(), [&](std::size_t i) { sim.sweep.motion[i].w = sim.particles.rest_volume[i]; }, 2048);
}

void find_density(Simulation& sim) {
    ScopedTimer timer(sim.stats.density_seconds);
    pack_motion(sim.particles, sim.clock.last_dt, incompressible(sim), sim.sweep);
    if (incompressible(sim)) {
        find_wall_effects(sim.walls, sim.particles.position, sim.sweep.walls);
        measure_density(sim.particles, sim.neighbours, sim.sweep.ghosts, sim.sweep.walls, sim.problem.smoothing,
                        sim.pressure_system);
        return pack_without_pressure(sim.particles, sim.problem.materials, sim.sweep);
    }
    pack_phases(sim.particles, sim.solids, sim.problem.smoothing, sim.sweep);
    if (sim.sweep.mixed) keep_elastic_state(sim.particles, sim.elastic_state);
    compute_density(sim.particles, sim.neighbours, sim.walls, sim.problem.smoothing, sim.sweep);
    compute_pressure(sim.particles, sim.problem.materials, sim.sweep);
    if (sim.sweep.mixed) restore_elastic_state(sim.elastic_state, sim.particles);
}

/// Everything that a sum over neighbours gives at the present places.
void sum_up(const Plan& plan, Simulation& sim) {
    if (!plan.neighbours) return;
    find_neighbours(sim);  // geometry   7.1
    if (plan.liquid)
        find_density(sim);  // density    2.3, 4.3.1
    else
        pack_still(sim);
}

void find_forces(const Plan& plan, Simulation& sim) {
    ScopedTimer timer(sim.stats.forces_seconds);
    if (!plan.liquid) {
        std::ranges::fill(sim.particles.acceleration, Vec3::Zero());
        return;
    }
    const SweepInput input{sim.neighbours, sim.walls, sim.problem.smoothing, sim.sweep};
    if (incompressible(sim)) {
        compute_viscous_accelerations(sim.particles, input, sim.problem.outside);
    } else {
        const auto artificial = static_cast<Real>(sim.problem.scene.solver.artificial_viscosity);
        compute_accelerations(sim.particles, sim.neighbours, sim.problem.smoothing, {sim.problem.outside, artificial},
                              sim.sweep);
    }
    add_tension(sim.particles, input, sim.problem.tension, sim.problem.materials, sim.tension);
}

/// The viscous force acts for as long as the leapfrog's next kick.
void find_viscosity(Simulation& sim, double dt) {
    ScopedTimer timer(sim.stats.viscosity_seconds);
    const auto& materials = sim.problem.materials;
    const ViscositySolve params{.kick = 0.5 * (sim.clock.last_dt + dt),
                                .tolerance = sim.problem.scene.solver.viscosity_tolerance};
    const ViscosityReport report = solve_viscosity(
        sim.particles, {sim.neighbours, sim.walls, sim.problem.smoothing, sim.sweep}, materials, params, sim.viscosity);
    sim.stats.viscosity_iterations += report.iterations;
    sim.stats.viscosity_unconverged += report.converged ? 0 : 1;
    sim.stats.viscosity_residual = std::max(sim.stats.viscosity_residual, report.residual);
}

void conduct(Simulation& sim, double dt) {
    ScopedTimer timer(sim.stats.heat_seconds);
    std::vector<ScreenedPair> screened;
    if (sim.problem.heat.any()) screened = screened_heat(sim.particles, sim.neighbours, sim.solids, sim.crack_scratch);
    sim.stats.heat_steps +=
        conduct_heat(sim.particles, {sim.neighbours, sim.walls, sim.problem.smoothing, sim.sweep},
                     {sim.problem.materials, sim.problem.heat, screened}, sim.clock.time, dt, sim.heat);
}

void count_solve(const SolveReport& report, SolveStats& stats) {
    ++stats.solves;
    stats.iterations += report.iterations;
    stats.most = std::max(stats.most, report.iterations);
    stats.residual = std::max(stats.residual, report.residual);
    if (!report.converged) ++stats.cut_off;
}

void solve_pressure(Simulation& sim, double dt) {
    ScopedTimer timer(sim.stats.pressure_seconds);
    const scene::Solver& params = sim.problem.scene.solver;
    const double kick = 0.5 * (sim.clock.last_dt + dt);
    count_solve(remove_divergence(sim.particles, sim.neighbours, sim.sweep.walls, sim.problem.smoothing,
                                  {kick, dt, {params.divergence_tolerance, params.iterations}}, sim.pressure_system,
                                  sim.solve_scratch),
                sim.stats.divergence);
    count_solve(restore_density(sim.particles, sim.neighbours, sim.sweep.walls, sim.problem.smoothing,
                                {params.density_tolerance, params.iterations}, sim.pressure_system, sim.solve_scratch),
                sim.stats.density);
}

/// The push of liquids on walls in this step. It is the reaction to the walls' part of the force of pressure on each
/// particle, and to their adhesion. Nothing of it acts on what an emitter drives.
void press_walls(const Plan& plan, const std::vector<Index>& driven, double dt, Simulation& sim) {
    if (!plan.liquid || sim.walls.list.empty() || !sim.probes.needs_pushes()) return;
    const Particles& p = sim.particles;
    const Sweep& sweep = sim.sweep;
    const double kick = 0.5 * (sim.clock.last_dt + dt);
    const bool sticks = std::ranges::any_of(sim.walls.list, [](const Wall& w) { return w.adhesion > 0; }) &&
                        std::ranges::any_of(sim.problem.materials, [](const auto& m) { return m.tension > 0; });
    const auto pressure = [&](std::size_t i) {  // times a volume [N m]
        return incompressible(sim) ? p.mass[i] * sim.pressure_system.slope[i].w * p.pressure[i]
                                   : sweep.matter[i].z * std::max(sweep.place[i].w, Real(0)) * sweep.motion[i].w;
    };
    std::vector<Vec3> push(p.size(), Vec3::Zero());
    parallel_chunks(
        p.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(sim.walls);
            for (std::size_t i = begin; i < end; ++i) {
                if (!(sweep.walls[i].share > 0)) continue;
                Vec3 force = pressure(i) * sweep.walls[i].gradient;
                if (sticks)
                    force -=
                        adhesion_on(i, p, sim.walls, sim.problem.tension, sim.problem.materials, sim.tension, cursor);
                push[i] = static_cast<Real>(kick) * force;
            }
        },
        256);
    for (const Index i : driven) push[i].setZero();
    count_pushes(
        sim.probes, p, [&](std::size_t i) { return push[i]; }, sim.problem.smoothing.support);
    sim.probes.pressed += kick;
}

/// Walls stop what their pressure let through. That is a push, too.
void hold_off(double dt, double wall_speed, Simulation& sim) {
    const bool counts = sim.probes.needs_pushes();
    const std::vector<Vec3> before = counts ? sim.particles.velocity : std::vector<Vec3>{};
    sim.stats.passed_walls +=
        hold_off_walls(sim.walls, sim.particles, least_wall_distance(sim), sim.sweep.walls, dt, wall_speed);
    const auto stopped = [&](std::size_t i) -> Vec3 {
        return sim.particles.mass[i] * (before[i] - sim.particles.velocity[i]);
    };
    if (counts) count_pushes(sim.probes, sim.particles, stopped, sim.problem.smoothing.support);
}

/// Matter that an emitter drives moves as the emitter says, whatever presses against it. The pressure solve takes it for
/// infinitely heavy: its neighbours make way. Were it light, they would be told of a part of the flow alone.
std::vector<Index> drive_openings(const Plan& plan, Simulation& sim) {
    const auto driven = drive_openings(sources_of(sim), sim.clock.time, sim.emitters, sim.particles);
    for (const Index i : driven) {
        sim.particles.acceleration[i].setZero();
        if (plan.pressure_solve) sim.pressure_system.slope[i].w = 0;  // V0/(m k)
    }
    return driven;
}

void emit(Simulation& sim) {
    emit_particles(sources_of(sim), sim.clock.time, sim.clock.last_dt, sim.emitters, sim.particles, sim.next_id);
    adopt_particles(sim.problem.materials, sim.problem.smoothing, sim.particles, sim.solids);
}

void change_phases_of(Simulation& sim) {
    const std::vector<std::uint8_t> changed =
        change_phases(sim.problem.materials, sim.problem.outside, sim.clock.last_dt, sim.particles, sim.solids);
    if (!changed.empty()) bind_matter(changed, matter_of(sim));
}

/// The largest step that can follow the walls [s]. Walls are stiff springs to what a pressure p presses on them. Their
/// frequency follows from the curvature of their share (wall_kernel.h):
///
///     omega = sqrt(5 p/rho)/spacing   [1/s]
///
/// A step with explicit places must resolve it. In a tank at rest the mean of p/rho is half the largest:
///
///     dt <= cfl spacing/sqrt(2 mean(p/rho))   [s]
double pressure_limit(const Simulation& sim) {
    const Particles& p = sim.particles;
    const double sum = parallel_sum(
        p.size(), [&](std::size_t i) { return static_cast<double>(p.pressure[i] * p.rest_volume[i] / p.mass[i]); });
    return sim.problem.scene.solver.time_step.cfl * static_cast<double>(sim.problem.smoothing.spacing) /
           std::sqrt(2 * sum / std::max<double>(1, static_cast<double>(p.size())) + 1e-30);
}

/// A fixed step is taken whatever the state allows. What the scene itself sets as `maximum` is no limit of the method.
void note_long_step(StepLimits limits, double cracks, double dt, StepStats& stats) {
    limits.maximum = std::numeric_limits<double>::infinity();
    const double ratio = dt / std::min(limits.smallest(), cracks);
    if (ratio <= 1 + 1e-9) return;
    ++stats.long_steps;
    if (ratio <= stats.overstep) return;
    stats.overstep = ratio;
    stats.overstepped = cracks < limits.smallest() ? "cracks" : limits.cause();
}

double choose_step(const Plan& plan, Simulation& sim, double wall_speed) {
    const scene::TimeStep& params = sim.problem.scene.solver.time_step;
    // Solids alone: nothing but their own sub-steps sets the pace, for the walls act in those.
    const double cracks = sim.solids.cracks.step;
    if (!plan.liquid) {
        const double dt = divide_evenly(sim.clock.next_frame - sim.clock.time,
                                        params.fixed > 0 ? params.fixed : std::min(params.maximum, cracks));
        note_long_step(kNoLimits, cracks, dt, sim.stats);
        return dt;
    }
    StepLimits limits =
        step_limits(sim.particles, sim.sweep, sim.problem.materials, sim.problem.smoothing, params, wall_speed);
    if (incompressible(sim)) limits.signal = std::min(limits.signal, pressure_limit(sim));
    check_health(sim, limits);
    const double dt = divide_evenly(sim.clock.next_frame - sim.clock.time,
                                    params.fixed > 0 ? params.fixed : std::min(limits.smallest(), cracks));
    note_long_step(limits, cracks, dt, sim.stats);
    sim.stats.fastest = std::max(sim.stats.fastest, limits.fastest);
    if (dt < sim.stats.smallest_dt) sim.stats.limit = params.fixed > 0 ? "fixed" : limits.cause();
    sim.stats.smallest_dt = std::min(sim.stats.smallest_dt, dt);
    sim.stats.largest_dt = std::max(sim.stats.largest_dt, dt);
    return dt;
}

void shift(Particles& particles, const std::vector<Vec3>& by) {
    parallel_for(
        particles.size(), [&](std::size_t i) { particles.position[i] += by[i]; }, 4096);
}

/// Asks whether a load comes near the strength of what can break. An impact comes and goes within a step: it has to end
/// there, so that cracks see the load. Nobody asks where a liquid or heat goes by the same step. Nor once the load
/// is that high: steps are short then.
std::function<bool()> load_watch(const Plan& plan, Simulation& sim) {
    const Solids& solids = sim.solids;
    if (solids.breaking.empty() || plan.liquid || sim.problem.heat.any() || solids.cracks.load >= kWatched) return {};
    return [&sim] { return load_now(sim.solids) >= kWatched; };
}

/// Elasticity, in sub-steps from the present time on. Returns how far the solids went [s].
double move_solids(const Plan& plan, double dt, Simulation& sim) {
    if (!plan.solids) return dt;
    const bool alone = !plan.liquid;
    ScopedTimer timer(sim.stats.solids_seconds);
    if (!alone) push_by_liquid(sim.particles, 0.5 * (sim.clock.last_dt + dt), sim.solids);
    prepare_stencils(sim.problem.materials, sim.clock.time, sim.particles, sim.neighbours, sim.solids);
    const SolidStep step{sim.problem, sim.clock.time, dt, load_watch(plan, sim)};
    const SolidReport report = advance_solids(step, sim.walls, sim.particles, sim.solids, sim.solid_scratch);
    sim.stats.solid_sub_steps += report.sub_steps;
    sim.stats.solid_newton += report.newton;
    sim.stats.solid_iterations += report.iterations;
    sim.stats.solid_unconverged += report.unconverged;
    sim.stats.contact_seconds += report.contact_seconds;
    write_particles(sim.solids, sim.particles);
    check_solids_health(sim, report);
    if (!alone) return report.dt;
    const double speed2 = parallel_reduce(
        sim.particles.size(), 0.0,
        [&](std::size_t i) { return static_cast<double>(sim.particles.velocity[i].squaredNorm()); },
        [](double a, double b) { return std::max(a, b); });
    sim.stats.fastest = std::max(sim.stats.fastest, std::sqrt(speed2));
    sim.stats.limit = "elastic";
    sim.stats.smallest_dt = std::min(sim.stats.smallest_dt, report.smallest_dt);
    sim.stats.largest_dt = std::max(sim.stats.largest_dt, report.dt);
    return report.dt;
}

/// Cracks go as far as the stress of the step's end drives them.
void break_solids(const Plan& plan, Simulation& sim) {
    if (!plan.solids || sim.solids.breaking.empty()) return;
    ScopedTimer timer(sim.stats.cracks_seconds);
    const CrackReport report =
        advance_cracks(sim.clock.time, sim.clock.last_dt, static_cast<std::uint64_t>(sim.clock.step), matter_of(sim),
                       sim.crack_scratch);
    sim.stats.cracks_begun += static_cast<int>(report.begun);
    sim.stats.fragments += static_cast<int>(report.fragments);
}

void move_on(const Plan& plan, double dt, double wall_speed, Simulation& sim) {
    Clock& c = sim.clock;
    const bool alone = !plan.liquid;
    note_positions(sim.probes, sim.particles);
    dt = move_solids(plan, dt, sim);
    ScopedTimer timer(sim.stats.integration_seconds);
    if (!alone) leapfrog(sim.particles, c.last_dt, dt);
    if (incompressible(sim) && !alone) {
        if (!sim.problem.periodic.any()) keep_spin(sim.sweep.walls, sim.solve_scratch.shift, sim.particles);
        shift(sim.particles, sim.solve_scratch.shift);
    }
    const double rest = c.next_frame - c.time;
    c.time = dt >= rest * (1 - 1e-9) ? c.next_frame : c.time + dt;
    c.last_dt = dt;
    ++c.step;
    move_walls(sim.walls, c.time);
    if (!alone) hold_off(dt, wall_speed, sim);
    count_passages(sim.probes, sim.particles, sim.problem.periodic);
    wrap_particles(sim.problem.periodic, sim.particles);
}

void count_step(Simulation& sim) {
    ++sim.stats.steps;
    sim.stats.particle_steps += static_cast<std::int64_t>(sim.particles.size());
    sim.stats.pairs += static_cast<std::int64_t>(sim.neighbours.total());
}

}  // namespace

double frame_time(const scene::Frames& frames, int frame) { return (frame - frames.first) / frames.fps; }

void evaluate(Simulation& sim) {
    const Plan plan = plan_step(sim);
    if (!plan.neighbours) return place_solids(sim);
    sum_up(plan, sim);
}

Real shown_pressure(const Simulation& sim, std::size_t i) {
    const auto& pressure = sim.particles.pressure;
    return incompressible(sim) && !is_elastic(sim.particles.phase[i])
               ? virial_pressure(i, pressure, sim.neighbours, sim.sweep.walls, sim.problem.smoothing,
                                 sim.pressure_system)
               : pressure[i];
}

void step(Simulation& sim) {
    emit(sim);              // sources    4.2
    change_phases_of(sim);  // melting, freezing  6.5
    const Plan plan = plan_step(sim);
    sum_up(plan, sim);       // geometry, density
    find_forces(plan, sim);  // forces     4.3, 4.4.2
    const double wall_speed = largest_wall_speed(sim.walls, sim.particles.position);
    const double dt = choose_step(plan, sim, wall_speed);         // time_step, health
    if (plan.viscosity_solve) find_viscosity(sim, dt);            // viscosity_solver  4.3.1
    const std::vector<Index> driven = drive_openings(plan, sim);  // sources
    if (plan.pressure_solve) solve_pressure(sim, dt);
    press_walls(plan, driven, dt, sim);  // probes
    conduct(sim, dt);                    // heat       6.5
    move_on(plan, dt, wall_speed, sim);  // leapfrog   7.2, solids  5.3, 6.3, walls
    break_solids(plan, sim);             // fracture   5.6
    update_surface_when_due(plan, sim);  // surface    6.6
    count_step(sim);
}

bool advance_frame(Simulation& sim, const std::function<bool()>& stop) {
    const scene::Frames& frames = sim.problem.scene.frames;
    sim.clock.next_frame = frame_time(frames, sim.clock.frame + 1);
    while (sim.clock.time < sim.clock.next_frame) {
        if (stop()) return false;
        step(sim);
    }
    ++sim.clock.frame;
    make_frame_surface(sim);
    evaluate(sim);
    return true;
}

}  // namespace thixo
