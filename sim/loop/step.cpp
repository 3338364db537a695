#include "sim/loop/step.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "sim/bonds/members.h"
#include "sim/liquid/density.h"
#include "sim/liquid/forces.h"
#include "sim/liquid/leapfrog.h"
#include "sim/loop/coupling.h"
#include "sim/loop/health.h"
#include "sim/loop/plan.h"
#include "sim/loop/time_step.h"
#include "sim/phase/phases.h"
#include "sim/surface/contact_surface.h"

namespace thixo {
namespace {

bool incompressible(const Simulation& s) { return s.problem.strategy.incompressible; }

// The least distance of a particle from a wall [m]. Pressure holds the first layer half a spacing off. This catches
// what no pressure holds: single drops, and what an impact presses on. The implicit solver's walls hold particles by
// themselves, some nearer than that. To move these back would thrust them among their neighbours.
Real least_wall_distance(const Simulation& s) {
    return (incompressible(s) ? Real(0.2) : Real(0.45)) * s.problem.smoothing.spacing;
}

void sort_particles(Simulation& s) {
    const std::vector<Index> order =
        PointGrid::sort_order(s.particles.position, s.particles.id, s.problem.smoothing.support);
    reorder_table(s.particles, order, s.reorder_scratch);
    locate_particles(s.particles, s.solids);
}

void find_neighbours(Simulation& s) {
    ScopedTimer timer(s.stats.neighbours_seconds);
    sort_particles(s);
    const Real support = s.problem.smoothing.support;
    find_ghosts(s.problem.periodic, s.particles.position, support, s.sweep.ghosts);
    if (s.problem.periodic.any()) {
        append_ghosts(s.sweep.ghosts, s.particles.position, s.places);
        s.grid.build(s.places, support);
    } else {
        s.grid.build(s.particles.position, support);
    }
    s.neighbours.build(s.grid, support, s.particles.size());
}

/// Sorts the particles, builds the grid and finds v(t). For steps in which nothing asks for neighbours, but for those
/// at rest.
void place_solids(Simulation& s) {
    sort_particles(s);
    find_ghosts(s.problem.periodic, s.particles.position, s.problem.smoothing.support, s.sweep.ghosts);
    s.grid.build(s.particles.position, s.problem.smoothing.support);
    pack_motion(s.particles, 0, false, s.sweep);
}

/// Packs what heat conduction reads, in steps without a liquid whose density is asked for.
void pack_still(Simulation& s) {
    pack_motion(s.particles, 0, false, s.sweep);
    find_wall_effects(s.walls, s.particles.position, s.sweep.walls);
    parallel_for(
        s.particles.size(), [&](std::size_t i) { s.sweep.motion[i].w = s.particles.rest_volume[i]; }, 2048);
}

void find_density(Simulation& s) {
    ScopedTimer timer(s.stats.density_seconds);
    pack_motion(s.particles, s.clock.last_dt, incompressible(s), s.sweep);
    if (incompressible(s)) {
        find_wall_effects(s.walls, s.particles.position, s.sweep.walls);
        measure_density(s.particles, s.neighbours, s.sweep.ghosts, s.sweep.walls, s.problem.smoothing,
                        s.pressure_system);
        return pack_without_pressure(s.particles, s.problem.materials, s.sweep);
    }
    pack_phases(s.particles, s.solids, s.problem.smoothing, s.sweep);
    if (s.sweep.mixed) keep_elastic_state(s.particles, s.elastic_state);
    compute_density(s.particles, s.neighbours, s.walls, s.problem.smoothing, s.sweep);
    compute_pressure(s.particles, s.problem.materials, s.sweep);
    if (s.sweep.mixed) restore_elastic_state(s.elastic_state, s.particles);
}

/// Everything that a sum over neighbours gives at the present places.
void sum_up(const Plan& plan, Simulation& s) {
    if (!plan.neighbours) return;
    find_neighbours(s);  // geometry   7.1
    if (plan.liquid)
        find_density(s);  // density    2.3, 4.3.1
    else
        pack_still(s);
}

void find_forces(const Plan& plan, Simulation& s) {
    ScopedTimer timer(s.stats.forces_seconds);
    if (!plan.liquid) {
        std::ranges::fill(s.particles.acceleration, Vec3::Zero());
        return;
    }
    const ForceParams params{s.problem.outside, static_cast<Real>(s.problem.scene.solver.artificial_viscosity)};
    compute_accelerations(s.particles, s.neighbours, s.problem.smoothing, params, s.sweep);
    add_tension(s.particles, {s.neighbours, s.walls, s.problem.smoothing, s.sweep}, s.problem.tension,
                s.problem.materials, s.tension);
}

/// The viscous force acts for as long as the leapfrog's next kick.
void find_viscosity(Simulation& s, double dt) {
    ScopedTimer timer(s.stats.viscosity_seconds);
    const auto& materials = s.problem.materials;
    const ViscositySolve params{.kick = 0.5 * (s.clock.last_dt + dt),
                                .tolerance = s.problem.scene.solver.viscosity_tolerance};
    const ViscosityReport report = solve_viscosity(s.particles, {s.neighbours, s.walls, s.problem.smoothing, s.sweep},
                                                   materials, params, s.viscosity);
    s.stats.viscosity_iterations += report.iterations;
    s.stats.viscosity_unconverged += report.converged ? 0 : 1;
    s.stats.viscosity_residual = std::max(s.stats.viscosity_residual, report.residual);
}

void conduct(Simulation& s, double dt) {
    ScopedTimer timer(s.stats.heat_seconds);
    s.stats.heat_steps += conduct_heat(s.particles, {s.neighbours, s.walls, s.problem.smoothing, s.sweep},
                                       s.problem.heat, s.clock.time, dt, s.heat);
}

void count_solve(const SolveReport& report, SolveStats& stats) {
    ++stats.solves;
    stats.iterations += report.iterations;
    stats.most = std::max(stats.most, report.iterations);
    stats.residual = std::max(stats.residual, report.residual);
    if (!report.converged) ++stats.cut_off;
}

void solve_pressure(Simulation& s, double dt) {
    ScopedTimer timer(s.stats.pressure_seconds);
    const scene::Solver& params = s.problem.scene.solver;
    const double kick = 0.5 * (s.clock.last_dt + dt);
    count_solve(remove_divergence(s.particles, s.neighbours, s.sweep.walls, s.problem.smoothing,
                                  {kick, dt, {params.divergence_tolerance, params.iterations}}, s.pressure_system,
                                  s.solve_scratch),
                s.stats.divergence);
    count_solve(restore_density(s.particles, s.neighbours, s.sweep.walls, s.problem.smoothing,
                                {params.density_tolerance, params.iterations}, s.pressure_system, s.solve_scratch),
                s.stats.density);
}

/// Matter that an emitter drives moves as the emitter says, whatever presses against it.
void drive_openings(Simulation& s) {
    const auto driven = drive_openings(sources_of(s), s.clock.time, s.emitters, s.particles);
    for (const Index i : driven) {
        s.particles.acceleration[i].setZero();
        if (incompressible(s)) s.solve_scratch.shift[i].setZero();
    }
}

void emit(Simulation& s) {
    emit_particles(sources_of(s), s.clock.time, s.clock.last_dt, s.emitters, s.particles, s.next_id);
    adopt_particles(s.problem.scene, s.problem.smoothing, s.particles, s.solids);
}

/// The largest step that can follow the walls [s]. Walls are stiff springs to what a pressure p presses on them. Their
/// frequency follows from the curvature of their share (wall_kernel.h):
///
///     omega = sqrt(5 p/rho)/spacing   [1/s]
///
/// A step with explicit places must resolve it. In a tank at rest the mean of p/rho is half the largest:
///
///     dt <= cfl spacing/sqrt(2 mean(p/rho))   [s]
double pressure_limit(const Simulation& s) {
    const Particles& p = s.particles;
    const double sum = parallel_sum(
        p.size(), [&](std::size_t i) { return static_cast<double>(p.pressure[i] * p.rest_volume[i] / p.mass[i]); });
    return s.problem.scene.solver.time_step.cfl * static_cast<double>(s.problem.smoothing.spacing) /
           std::sqrt(2 * sum / std::max<double>(1, static_cast<double>(p.size())) + 1e-30);
}

double choose_step(const Plan& plan, Simulation& s, double wall_speed) {
    const scene::TimeStep& params = s.problem.scene.solver.time_step;
    // Solids alone: nothing but their own sub-steps sets the pace, for the walls act in those.
    if (!plan.liquid)
        return divide_evenly(s.clock.next_frame - s.clock.time, params.fixed > 0 ? params.fixed : params.maximum);
    StepLimits limits = step_limits(s.particles, s.sweep, s.problem.materials, s.problem.smoothing, params, wall_speed);
    if (incompressible(s)) limits.signal = std::min(limits.signal, pressure_limit(s));
    check_health(s, limits);
    const double dt =
        divide_evenly(s.clock.next_frame - s.clock.time, params.fixed > 0 ? params.fixed : limits.smallest());
    s.stats.fastest = std::max(s.stats.fastest, limits.fastest);
    if (dt < s.stats.smallest_dt) s.stats.limit = params.fixed > 0 ? "fixed" : limits.cause();
    s.stats.smallest_dt = std::min(s.stats.smallest_dt, dt);
    s.stats.largest_dt = std::max(s.stats.largest_dt, dt);
    return dt;
}

void shift(Particles& particles, const std::vector<Vec3>& by) {
    parallel_for(
        particles.size(), [&](std::size_t i) { particles.position[i] += by[i]; }, 4096);
}

/// Elasticity, in sub-steps from the present time on.
void move_solids(const Plan& plan, double dt, Simulation& s) {
    if (!plan.solids) return;
    const bool alone = !plan.liquid;
    ScopedTimer timer(s.stats.solids_seconds);
    if (!alone) push_by_liquid(s.particles, 0.5 * (s.clock.last_dt + dt), s.solids);
    prepare_stencils(s.problem.scene, s.clock.time, s.problem.smoothing, s.particles, s.neighbours, s.solids);
    const SolidStep step{s.problem.scene, s.problem.outside, s.clock.time, dt, s.problem.strategy.implicit_solids};
    const SolidReport report = advance_solids(step, s.walls, s.particles, s.solids, s.solid_scratch);
    s.stats.solid_sub_steps += report.sub_steps;
    s.stats.solid_newton += report.newton;
    s.stats.solid_iterations += report.iterations;
    s.stats.solid_unconverged += report.unconverged;
    s.stats.contact_seconds += report.contact_seconds;
    write_particles(s.solids, s.particles);
    check_solids_health(s, report);
    if (!alone) return;
    const double speed2 = parallel_reduce(
        s.particles.size(), 0.0,
        [&](std::size_t i) { return static_cast<double>(s.particles.velocity[i].squaredNorm()); },
        [](double a, double b) { return std::max(a, b); });
    s.stats.fastest = std::max(s.stats.fastest, std::sqrt(speed2));
    s.stats.limit = "elastic";
    s.stats.smallest_dt = std::min(s.stats.smallest_dt, report.smallest_dt);
    s.stats.largest_dt = std::max(s.stats.largest_dt, dt);
}

void move_on(const Plan& plan, double dt, double wall_speed, Simulation& s) {
    Clock& c = s.clock;
    const bool alone = !plan.liquid;
    note_positions(s.probes, s.particles);
    move_solids(plan, dt, s);
    ScopedTimer timer(s.stats.integration_seconds);
    if (!alone) leapfrog(s.particles, c.last_dt, dt);
    if (incompressible(s) && !alone) shift(s.particles, s.solve_scratch.shift);
    const double rest = c.next_frame - c.time;
    c.time = dt >= rest * (1 - 1e-9) ? c.next_frame : c.time + dt;
    c.last_dt = dt;
    ++c.step;
    move_walls(s.walls, c.time);
    if (!alone) hold_off_walls(s.walls, s.particles, least_wall_distance(s), s.sweep.walls, dt, wall_speed);
    count_passages(s.probes, s.particles, s.problem.periodic);
    wrap_particles(s.problem.periodic, s.particles);
}

/// The largest of term(i) [m^2] over all particles, as a length [m].
template <class Term>
double largest(const Simulation& s, Term&& term) {
    return std::sqrt(parallel_reduce(
        s.particles.size(), 0.0, [&](std::size_t i) { return static_cast<double>(term(i)); },
        [](double a, double b) { return std::max(a, b); }));
}

/// Whether the surface has to be updated. Surfels are carried by the displacement of the particles about them. That is
/// exact where the displacement is affine, so that a jet in free flight needs no update. What counts is therefore the
/// displacement of a particle against the mean of its neighbours. The update is due when it is more than a quarter of
/// the surfel support (dissertation 6.6) for one particle in twenty. A single one is not enough: in a splash some drop
/// always moves that far. Its few surfels are made anew at the next update in any case. Matter that moves as a whole
/// may move two supports.
bool surface_due(const Plan& plan, const Simulation& s) {
    constexpr double kShare = 0.05;
    const scene::Surface& params = s.problem.scene.surface;
    if (!params.enabled || !plan.liquid) return false;
    const double support = params.support * params.radius * static_cast<double>(s.problem.smoothing.spacing);
    const auto& x = s.particles.position;
    const auto& x0 = s.particles.surface_position;
    const double moved = largest(s, [&](std::size_t i) { return (x[i] - x0[i]).squaredNorm(); });
    if (moved < support / 4) return false;
    if (moved > 2 * support) return true;
    const double stirred = parallel_sum(s.particles.size(), [&](std::size_t i) {
        const auto near = s.neighbours[i];
        if (near.empty()) return 0.0;
        Vec3 sum(0, 0, 0);
        for (const Index j : near) sum += x[j] - x0[j];
        const Real against = (x[i] - x0[i] - sum / static_cast<Real>(near.size())).squaredNorm();
        return against > square(static_cast<Real>(support / 4)) ? 1.0 : 0.0;
    });
    return stirred > kShare * static_cast<double>(s.particles.size());
}

void update_surface_when_due(const Plan& plan, Simulation& s) {
    if (surface_due(plan, s)) refresh_surface(s);
}

void count_step(Simulation& s) {
    ++s.stats.steps;
    s.stats.particle_steps += static_cast<std::int64_t>(s.particles.size());
    s.stats.pairs += static_cast<std::int64_t>(s.neighbours.total());
}

}  // namespace

double frame_time(const scene::Frames& frames, int frame) { return (frame - frames.first) / frames.fps; }

void evaluate(Simulation& s) {
    const Plan plan = plan_step(s);
    if (!plan.neighbours) return place_solids(s);
    sum_up(plan, s);
}

Real shown_pressure(const Simulation& s, std::size_t i) {
    const auto& pressure = s.particles.pressure;
    return incompressible(s) && !is_elastic(s.particles.phase[i])
               ? virial_pressure(i, pressure, s.neighbours, s.sweep.walls, s.problem.smoothing, s.pressure_system)
               : pressure[i];
}

void step(Simulation& s) {
    emit(s);  // sources    4.2
    change_phases(s.problem.scene, s.problem.outside, s.clock.last_dt, s.particles,
                  s.solids);  // melting, freezing  6.5
    const Plan plan = plan_step(s);
    sum_up(plan, s);       // geometry, density
    find_forces(plan, s);  // forces     4.3, 4.4.2
    const double wall_speed = largest_wall_speed(s.walls, s.particles.position);
    const double dt = choose_step(plan, s, wall_speed);  // time_step, health
    if (plan.viscosity_solve) find_viscosity(s, dt);     // viscosity_solver  4.3.1
    if (plan.pressure_solve) solve_pressure(s, dt);
    drive_openings(s);                 // sources
    conduct(s, dt);                    // heat       6.5
    move_on(plan, dt, wall_speed, s);  // leapfrog   7.2, solids  5.3, 6.3, walls
    update_surface_when_due(plan, s);  // surface    6.6
    count_step(s);
}

void refresh_surface(Simulation& s) {
    if (!s.problem.scene.surface.enabled) return;
    ScopedTimer timer(s.stats.surface_seconds);
    const Smoothing& smoothing = s.problem.smoothing;
    const scene::Surface& params = s.problem.scene.surface;
    const SurfaceSetting setting{s.walls, params, smoothing.spacing, smoothing.support, s.problem.moulds};
    const SurfaceReport report = s.solids.empty() ? update_surface(s.surface, s.particles, setting)
                                                  : update_mixed_surface(s.embedded, s.solids, s.particles, setting,
                                                                         s.mixed_surface, s.surface, s.embedded_source);
    if (!s.solids.empty() && !s.solids.softening.any)
        draw_contacts(s.embedded, s.embedded_source, s.walls, s.solids, s.surface);
    SurfaceReport& sum = s.stats.surface;
    const SurfaceReport before = sum;
    sum = report;
    sum.inserted += before.inserted;
    sum.deleted += before.deleted;
    add(before.seconds, sum.seconds);
    ++s.stats.surface_updates;
}

bool advance_frame(Simulation& s, const std::function<bool()>& stop) {
    const scene::Frames& frames = s.problem.scene.frames;
    s.clock.next_frame = frame_time(frames, s.clock.frame + 1);
    while (s.clock.time < s.clock.next_frame) {
        if (stop()) return false;
        step(s);
    }
    ++s.clock.frame;
    refresh_surface(s);
    evaluate(s);
    return true;
}

}  // namespace thixo
