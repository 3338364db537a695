#include "sim/loop/solid_steps.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/timer.h"
#include "pipeline/geometry/shapes.h"
#include "sim/bonds/gradients.h"
#include "sim/contact/contact.h"
#include "sim/contact/walls.h"
#include "sim/external/handles.h"
#include "sim/loop/time_step.h"
#include "sim/phase/phases.h"
#include "sim/solid/elasticity.h"
#include "sim/solid/laws.h"
#include "sim/solid/rigid_fit.h"
#include "sim/solid/rigid_pieces.h"
#include "sim/solid/stable_step.h"

namespace thixo {
namespace {

/// Whether the fastest rates are still good enough: cracks alone have changed bonds, and only in the last few steps.
/// Sub-steps keep a margin (stable_step.h) that is larger than what some more elements beside a crack add.
bool rates_hold(const Solids& solids) {
    constexpr std::uint64_t kSteps = 16;
    const Bonds& bonds = solids.elements.bonds;
    return !solids.softening.any && bonds.weakened < kSteps && solids.rates_version + bonds.weakened == bonds.version &&
           solids.rates.size() == solids.bodies.size();
}

/// Computes the laws of all bodies at a time, and the values that follow from laws and bonds.
void update_laws(const Problem& problem, double time, Solids& solids) {
    std::vector<StressLaw> laws;
    std::vector<Stiffness6> anisotropic;
    for (const SolidBody& body : solids.bodies) {
        const ResolvedMaterial& material = problem.materials[static_cast<std::size_t>(body.material)];
        laws.push_back(law_at(material, time));
        const scene::Orthotropic& o = material.elastic.front().elastic.orthotropic;
        if (!o.any() || !body.shaped()) continue;
        const Quatd own =
            rotation_from_degrees(problem.scene.bodies[static_cast<std::size_t>(body.source)].shape.rotate);
        laws.back().anisotropy = static_cast<Index>(anisotropic.size());
        anisotropic.push_back(orthotropic_stiffness(o, (own * rotation_from_degrees(o.rotate)).toRotationMatrix()));
    }
    Bonds& bonds = solids.elements.bonds;
    if (laws != solids.laws) bonds.changed();
    if (solids.rates_version == bonds.version) return;
    if (rates_hold(solids)) {
        set_zero_energy(solids.laws, solids.elements);
        return;
    }
    bonds.weakened = 0;
    solids.rates_version = bonds.version;
    solids.laws = std::move(laws);
    solids.elements.anisotropic = std::move(anisotropic);
    std::vector<Index> own;  // rates are computed with the bodies' laws
    solids.elements.law.swap(own);
    set_zero_energy(solids.laws, solids.elements);
    if (!problem.strategy.implicit_solids)
        solids.rates = find_fastest_rates(solids.laws, solids.bodies, solids.elements);
    solids.elements.law.swap(own);
    if (solids.softening.any) set_zero_energy(stencil_laws(solids), solids.elements);
}

/// One sub-step of leapfrog, with the walls:
///     v(t + dt/2) = v(t - dt0/2) + (dt0 + dt)/2 (f/m + a_np)
///     x(t + dt) = x(t) + dt v(t + dt/2)
void leapfrog_elements(const Walls& walls, const Periodic& periodic, double dt, Solids& solids) {
    Elements& e = solids.elements;
    const Real kick = static_cast<Real>(0.5 * (solids.last_dt + dt)), drift = static_cast<Real>(dt);
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    parallel_chunks(
        e.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            WallCursor cursor(walls);
            for (std::size_t i = begin; i < end; ++i) {
                if (solids.held[i] || !is_elastic(e.phase_of(i))) continue;
                const auto owner = static_cast<std::size_t>(e.owner[i]);
                const Vec3 before = xyz(e.velocity[i]);
                Vec3 v = before + kick * (solids.force[i] / e.mass[i] + solids.external[i]);
                Vec3 u = xyz(e.displacement[i]);
                if (!walls.list.empty())
                    push_off_walls(walls, periodic,
                                   {contact_law(solids, i), poses[owner], e, i, layer_beside_walls(solids, i)},
                                   {kick, drift}, cursor, u, v);
                else
                    u += drift * v;
                e.acceleration[i] = (v - before) / kick;
                e.velocity[i] = quad(v);
                e.displacement[i] = quad(u);
            }
        },
        256);
}

bool any_flows(const Solids& solids) {
    return solids.softening.any || std::ranges::any_of(solids.laws, [](const StressLaw& law) { return law.creep > 0; });
}

/// The forces of elasticity at the start of a sub-step. A step ends with the flow that belongs to its places.
void find_elastic_forces(bool first, double dt, Solids& solids, SolidScratch& scratch) {
    const std::vector<StressLaw>& laws = stencil_laws(solids);
    const FlowTimes times{first ? 0 : solids.last_dt / 2, dt / 2};
    StretchBounds bounds = any_flows(solids)
                               ? flow_and_find_stress_forces(laws, times, solids.elements, scratch.stress, solids.force)
                               : find_stress_forces(laws, solids.elements, scratch.stress, solids.force);
    bounds.add(add_flow_forces(solids, scratch.flow_stress));
    solids.stretch2 = static_cast<double>(bounds.stretch2);
    solids.stiffening = static_cast<double>(bounds.stiffening);
}

/// Plastic flow over dt at the present places. Leaves the gradients there.
void flow_for(double dt, Solids& solids) {
    if (!any_flows(solids)) return;
    find_gradients(solids.elements, solids.gradients);
    flow_plastically(stencil_laws(solids), dt, solids.gradients, solids.elements);
}

/// Steel at a spacing of a millimetre needs some 4e5 sub-steps in a frame. More than a million in one step come from a
/// state that has no motion. They would not end, or not move the clock at all.
bool is_stuck(double stable, double whole, int taken) {
    constexpr int kMost = 1'000'000;
    return !(stable * kMost >= whole) || taken > kMost;
}

/// Sub-steps of leapfrog to the end of the step.
void leapfrog_through(const SolidStep& whole, Walls& walls, Solids& solids, RigidPieces& rigid, SolidScratch& scratch,
                      SolidReport& report) {
    constexpr int kAsked = 8;  // sub-steps: a wave goes some four widths of a particle in them
    const double time = whole.time, end = time + whole.dt;
    double now = time;
    while (now < end) {
        move_walls(walls, now);
        if (now == time || now >= solids.contacts.next) {
            if (now != time) follow_contacts(walls, solids);
            ScopedTimer timer(report.contact_seconds);
            find_contacts(walls, now, end - now, solids);
        }
        const double until = std::min(end, solids.contacts.next);
        const double stable = stable_sub_step(solids, !walls.list.empty());
        report.stuck = is_stuck(stable, end - time, report.sub_steps);
        if (report.stuck) {
            report.smallest_dt = std::min(report.smallest_dt, stable);
            return;
        }
        const double step = divide_evenly(until - now, stable);
        find_elastic_forces(now == time, step, solids, scratch);
        {
            ScopedTimer timer(report.contact_seconds);
            add_contact_forces(walls, step, solids);
        }
        leapfrog_elements(walls, whole.problem.periodic, step, solids);
        rigid.follow(step, 0.5 * (solids.last_dt + step), solids);
        now = step >= (until - now) * (1 - 1e-9) ? until : now + step;
        move_held(now, step, solids);
        drift_flow(step, solids);
        solids.last_dt = step;
        ++report.sub_steps;
        report.smallest_dt = std::min(report.smallest_dt, step);
        if (now < end && whole.ends && report.sub_steps % kAsked == 0 && whole.ends()) break;
    }
    if (now < end) report.dt = now - time;
    flow_for(solids.last_dt / 2, solids);
}

/// The state before a step, restored where the step fails.
struct SavedState {
    std::vector<std::pair<Mat3d, Vec3d>> poses;
    std::vector<Quad> displacement, velocity;
    std::vector<Vec3> external;
    ContactNodes nodes;

    explicit SavedState(const Solids& solids)
        : displacement(solids.elements.displacement),
          velocity(solids.elements.velocity),
          external(solids.external),
          nodes(solids.contacts.nodes) {
        for (const SolidBody& b : solids.bodies) poses.emplace_back(b.turn, b.place);
    }
    void restore(Solids& solids) const {
        for (std::size_t b = 0; b < poses.size(); ++b)
            std::tie(solids.bodies[b].turn, solids.bodies[b].place) = poses[b];
        solids.elements.displacement = displacement;
        solids.elements.velocity = velocity;
        solids.external = external;
        solids.contacts.nodes = nodes;
    }
};

/// Takes implicit steps to the end of the step, each as long as contact is foreseen. Where Newton's method does not converge the step
/// is halved. A least part of the whole time bounds this, so that the halving ends.
void step_implicitly_through(const SolidStep& whole, Walls& walls, Solids& solids, RigidPieces& rigid,
                             ImplicitScratch& scratch, SolidReport& report) {
    constexpr double kMostParts = 64;
    const double time = whole.time, end = time + whole.dt, shortest = whole.dt / kMostParts;
    const double tolerance = whole.problem.scene.solver.solids_tolerance;
    double now = time;
    while (now < end) {
        {
            ScopedTimer timer(report.contact_seconds);
            find_contacts(walls, now, end - now, solids);
        }
        const SavedState saved(solids);
        double step = std::min(end, solids.contacts.next) - now;
        report.stuck = is_stuck(end - time, end - time, report.sub_steps);
        if (report.stuck) return;
        for (;; step = std::max(step / 2, shortest)) {
            const ImplicitReport done = step_implicitly(
                now, step, tolerance, walls, [&](double to, double dt) { move_held(to, dt, solids); }, solids, scratch);
            report.newton += done.newton;
            report.iterations += done.iterations;
            if (done.converged || step <= shortest) {
                report.unconverged += done.converged ? 0 : 1;
                break;
            }
            saved.restore(solids);
        }
        rigid.fit(solids);
        now = step >= (end - now) * (1 - 1e-9) ? end : now + step;
        solids.last_dt = step;
        flow_for(step, solids);
        ++report.sub_steps;
        report.smallest_dt = std::min(report.smallest_dt, step);
    }
}

/// Fits the rest shapes, by matter bound to the rest shape alone.
void fit_solids(Solids& solids) {
    if (!solids.softening.any) return fit_rest_shapes(solids.bodies, solids.elements);
    std::vector<Real> share(solids.elements.size());
    for (std::size_t i = 0; i < share.size(); ++i) share[i] = solids.elements.solidity(i);
    fit_rest_shapes(solids.bodies, solids.elements, &share);
}

}  // namespace

SolidReport advance_solids(const SolidStep& step, Walls& walls, Particles& particles, Solids& solids,
                           SolidScratch& scratch) {
    SolidReport report{.dt = step.dt};
    update_laws(step.problem, step.time, solids);
    take_hold(step.time, step.problem.outside, solids);
    RigidPieces rigid(solids);
    if (step.problem.strategy.implicit_solids)
        step_implicitly_through(step, walls, solids, rigid, scratch.implicit, report);
    else
        leapfrog_through(step, walls, solids, rigid, scratch, report);
    move_walls(walls, step.time + report.dt);
    if (report.stuck) return report;
    follow_contacts(walls, solids);
    if (solids.softening.any) absorb_flow(report.dt, particles, solids);
    fit_solids(solids);
    rigid.end(solids);
    return report;
}

void write_particles(Solids& solids, Particles& particles) {
    Elements& e = solids.elements;
    find_gradients(e, solids.gradients);
    const Real half = static_cast<Real>(0.5 * solids.last_dt);
    parallel_for(particles.size(), [&](std::size_t k) {
        if (!is_elastic(particles.phase[k])) return;
        const Index i = solids.element_of[static_cast<std::size_t>(particles.id[k])];
        const auto owner = static_cast<std::size_t>(e.owner[i]);
        const SolidBody& body = solids.bodies[owner];
        const Vec3d y = xyz(e.rest[i]).cast<double>() + xyz(e.displacement[i]).cast<double>();
        const Vec3 v = xyz(e.velocity[i]) + half * e.acceleration[i];
        particles.position[k] = (body.turn * y + body.place).cast<Real>();
        particles.velocity[k] = (body.turn * v.cast<double>()).cast<Real>();
        if (particles.phase[k] == Phase::viscoelastic) {
            particles.pressure[k] = flow_pressure(solids, i);
            return;
        }
        const Mat3& h = solids.gradients[i];
        particles.density[k] = e.mass[i] / e.volume[i] / std::max(volume_ratio(e, i, h), Real(1e-3));
        const Symmetric stress =
            solids.laws.empty()
                ? Symmetric{}
                : stress_of_shape(solids.softening.any ? solids.softening.law[i] : solids.laws[owner], e, i, h);
        particles.pressure[k] = -(stress.xx + stress.yy + stress.zz) / 3;
    });
}

}  // namespace thixo
