#include "sim/phase/phases.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "pipeline/base/parallel.h"
#include "sim/bonds/gradients.h"
#include "sim/bonds/members.h"
#include "sim/bonds/rest_shape.h"
#include "sim/bonds/weights.h"
#include "sim/phase/melt_stencils.h"
#include "sim/solid/elasticity.h"
#include "sim/solid/laws.h"
#include "sim/solid/stable_step.h"

namespace thixo {
namespace {

const ResolvedMaterial& material_of(const Materials& materials, const Particles& p, std::size_t k) {
    return materials[static_cast<std::size_t>(p.material[k])];
}

/// Starts the element of a particle that has just become solid: its displacement is that of the particle.
void enter_solid(const Particles& p, std::size_t k, Index i, Solids& solids) {
    Elements& e = solids.elements;
    const SolidBody& body = solids.bodies[static_cast<std::size_t>(e.owner[i])];
    const Vec3d y = body.turn.transpose() * (p.position[k].cast<double>() - body.place);
    e.displacement[i] = quad((y - xyz(e.rest[i]).cast<double>()).cast<Real>());
    e.velocity[i] = quad((body.turn.transpose() * p.velocity[k].cast<double>()).cast<Real>());
    e.acceleration[i] = Vec3::Zero();
    solids.softening.flow.plastic[i] = {};
    e.depth[i] = surface_depth(e, i);
}

/// The velocity of a solid particle lags by half a step of the liquid's push, but not of accelerations from outside
/// (sim/loop/step.h). A `part` of 1 adds that half step, -1 removes it.
void take_outside(const Outside& outside, Real part, Real half_step, Index k, Particles& p) {
    const Vec3 a = acceleration_from_outside(outside, p.position[k], p.velocity[k]);
    p.velocity[k] += part * half_step * a;
    p.acceleration[k] -= part * a;
}

/// Sets one particle's phase by its temperature. Returns whether it has just begun to melt.
bool change_phase(const ResolvedMaterial& m, const Outside& outside, Real half_step, Index k, Index i, Particles& p,
                  Solids& solids) {
    Elements& e = solids.elements;
    const Phase was = e.phase[i];
    const Real before = p.melt[k];
    const Real b = static_cast<Real>(m.melting.fraction(p.temperature[k]));
    const bool shape = m.keeps_shape(static_cast<double>(b));
    Phase now = was;
    if (was == Phase::liquid && shape) {
        now = Phase::viscoelastic;
        take_outside(outside, 1, half_step, k, p);
        enter_solid(p, k, i, solids);
    } else if (was != Phase::liquid && !shape) {
        now = Phase::liquid;
        take_outside(outside, -1, half_step, k, p);
    } else if (was == Phase::solid && b >= 1) {
        now = Phase::viscoelastic;
        e.depth[i] = surface_depth(e, i);
    }
    set_phase(now, b, k, i, p, e);
    return now == Phase::solid && b > 0 && before == 0;
}

}  // namespace

Real surface_depth(const Elements& e, std::size_t i) { return std::cbrt(e.volume[i]) / 2; }

void set_phase(Phase phase, Real b, Index particle, Index element, Particles& particles, Elements& elements) {
    particles.phase[particle] = elements.phase[element] = phase;
    particles.melt[particle] = elements.melt[element] = b;
}

namespace {

/// Makes the present shape of a body its rest shape.
void take_shape(const SolidBody& body, Particles& particles, Solids& solids) {
    Softening& s = solids.softening;
    Elements& e = solids.elements;
    const Mat3 turn = body.turn.cast<Real>();
    for (const Index i : body.elements) {
        Mat3 strain;  // minus the elastic strain
        if (e.phase[i] == Phase::viscoelastic) {
            strain = turn.transpose() * matrix(s.flow.plastic[i]) * turn;
        } else {
            const Mat3 q = rotation_of(Mat3::Identity() + solids.gradients[i]);
            strain = q * (matrix(e.plastic[i]) - matrix(strain_of(e, i, solids.gradients[i]))) * q.transpose();
        }
        e.plastic[i] = symmetric(strain);
        if (e.hardens) e.hardened[i] = 0;
        const Real stiffness = e.rest[i].w;
        e.rest[i] = quad(xyz(e.rest[i]) + xyz(e.displacement[i]), stiffness);
        e.displacement[i] = quad(Vec3::Zero());
        set_phase(Phase::solid, e.melt[i], solids.particle_of[i], i, particles, e);
    }
}

/// Refreezes bodies that are solid throughout, but not wholly bound to a rest shape.
void refreeze(Particles& particles, Solids& solids) {
    const Elements& e = solids.elements;
    bool any = false;
    for (SolidBody& body : solids.bodies) {
        const bool solid = body.shaped() && std::ranges::all_of(body.elements, [&](Index i) { return e.melt[i] == 0; });
        if (!solid || std::ranges::none_of(body.elements, [&](Index i) { return e.phase[i] == Phase::viscoelastic; }))
            continue;
        if (!any) find_gradients(e, solids.gradients);
        any = true;
        take_shape(body, particles, solids);
        body.refrozen = true;
        body.shape.reset();
    }
    if (any) find_refrozen_neighbours(solids);
}

/// Lists the rest neighbours of all bodies anew. Bonds that persist keep their visibility; new ones are visible.
void list_neighbours_anew(Solids& solids) {
    Bonds& bonds = solids.elements.bonds;
    const std::vector<std::size_t> begin = std::move(bonds.begin);
    const std::vector<Index> neighbour = std::move(bonds.neighbour);
    const std::vector<Real> visibility = std::exchange(bonds.visibility, {});
    find_rest_neighbours(solids.bodies, solids.elements, hang_together_in_shapes(solids));
    keep_bases(bonds);
    if (visibility.empty()) return;
    bonds.visibility.assign(bonds.neighbour.size(), 1);
    parallel_for(bonds.size(), [&](std::size_t i) {
        const auto first = neighbour.begin() + static_cast<std::ptrdiff_t>(begin[i]),
                   last = neighbour.begin() + static_cast<std::ptrdiff_t>(begin[i + 1]);
        for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k)
            if (const auto found = std::find(first, last, bonds.neighbour[k]); found != last)
                bonds.visibility[k] = visibility[static_cast<std::size_t>(found - neighbour.begin())];
    });
    weigh_bonds(solids.elements, kThin);
}

}  // namespace

void find_refrozen_neighbours(Solids& solids) {
    Elements& e = solids.elements;
    if (std::ranges::none_of(solids.bodies, &SolidBody::refrozen)) return;
    list_neighbours_anew(solids);
    std::vector<std::uint8_t> which(e.size());
    for (std::size_t i = 0; i < e.size(); ++i) which[i] = solids.owner(i).refrozen;
    measure_moments(e, &which, kThin);
}

void make_phases(const scene::Scene& scene, const Materials& materials, const Smoothing& smoothing,
                 Particles& particles, Solids& solids) {
    Softening& s = solids.softening;
    const auto elastic = [&](const std::string& name, bool melting) {
        for (std::size_t m = 0; m < materials.size(); ++m)
            if (scene.materials[m].name == name)
                return materials[m].solid() && (!melting || materials[m].melting.any());
        return false;
    };
    const bool emitted = std::ranges::any_of(scene.emitters, [&](const auto& e) { return elastic(e.material, false); });
    s.any = emitted || std::ranges::any_of(scene.bodies, [&](const auto& b) { return elastic(b.material, true); });
    if (!s.any) return;
    Elements& e = solids.elements;
    if (e.bonds.begin.empty()) e.bonds.begin.push_back(0);
    e.softens = true;
    e.phase.assign(e.size(), Phase::solid);
    e.melt.assign(e.size(), 0);
    for (Index k = 0; k < particles.size(); ++k)
        if (const Index i = solids.element(particles.id[k]); i != kNone)
            set_phase(particles.phase[k], particles.melt[k], k, i, particles, e);
    s.flow.plastic.resize(e.size());
    keep_bases(e.bonds);
    e.law.resize(e.size());
    std::iota(e.law.begin(), e.law.end(), Index(0));
    if (emitted) {
        std::int32_t material = 0;
        for (std::size_t m = 0; m < scene.materials.size(); ++m)
            for (const scene::Emitter& from : scene.emitters)
                if (from.material == scene.materials[m].name && materials[m].solid())
                    material = static_cast<std::int32_t>(m);
        solids.bodies.push_back({.id = -1, .source = -1, .material = material});
    }
    calibrate_rates(smoothing, s);
}

void adopt_particles(const Materials& materials, const Smoothing& smoothing, const Particles& particles,
                     Solids& solids) {
    if (!solids.softening.any || solids.bodies.empty()) return;
    const auto emitted = std::ranges::find_if(solids.bodies, [](const SolidBody& b) { return !b.shaped(); });
    if (emitted == solids.bodies.end()) return;
    std::vector<std::pair<std::int64_t, Index>> found;
    for (Index k = 0; k < particles.size(); ++k)
        if (material_of(materials, particles, k).solid() && solids.element(particles.id[k]) == kNone)
            found.emplace_back(particles.id[k], k);
    std::ranges::sort(found);
    Elements& e = solids.elements;
    for (const auto& [id, k] : found) {
        const auto i = static_cast<Index>(e.size());
        append_element(e, id, static_cast<std::int32_t>(emitted - solids.bodies.begin()));
        // Matter of emitters has no rest shape: its place there is the origin of the frame.
        e.mass[i] = particles.mass[k];
        e.volume[i] = e.quadrature[i] = particles.rest_volume[k];
        e.support[i] = smoothing.support;
        e.depth[i] = smoothing.spacing / 2;
        e.law[i] = i;
        e.phase[i] = Phase::liquid;
        e.melt[i] = 1;
        emitted->elements.push_back(i);
        solids.softening.flow.plastic.push_back({});
        solids.particle_of.push_back(k);
        number_element(id, i, solids);
    }
}

void change_phases(const Materials& materials, const Outside& outside, double last_dt, Particles& particles,
                   Solids& solids) {
    Softening& s = solids.softening;
    if (!s.any) return;
    Elements& e = solids.elements;
    const Real half_step = static_cast<Real>(0.5 * last_dt);
    std::vector<std::uint8_t> seeds(e.size(), 0);
    parallel_for(
        e.size(),
        [&](std::size_t element) {
            const auto i = static_cast<Index>(element);
            const Index k = solids.particle_of[i];
            const ResolvedMaterial& m = material_of(materials, particles, k);
            if (m.melting.any()) {
                seeds[i] = change_phase(m, outside, half_step, k, i, particles, solids) ? 1 : 0;
            } else if (e.phase[i] == Phase::liquid) {
                // A particle of an emitter is elastic, without a shape of its own.
                take_outside(outside, 1, half_step, k, particles);
                enter_solid(particles, k, i, solids);
                set_phase(Phase::viscoelastic, particles.melt[k], k, i, particles, e);
            }
        },
        1024);
    seed_flow(seeds, solids);
    refreeze(particles, solids);
    s.freezes = s.moves = false;
    for (std::size_t i = 0; i < e.size(); ++i) {
        s.freezes = s.freezes || e.phase[i] == Phase::viscoelastic || (e.phase[i] == Phase::solid && e.melt[i] > 0);
        s.moves = s.moves || is_elastic(e.phase[i]);
    }
}

const std::vector<StressLaw>& stencil_laws(const Solids& solids) {
    return solids.softening.any ? solids.softening.rest_law : solids.laws;
}

StressLaw contact_law(const Solids& solids, std::size_t i) {
    const Softening& s = solids.softening;
    if (!s.any) return solids.laws[static_cast<std::size_t>(solids.elements.owner[i])];
    return scaled(s.law[i], 1 - solids.elements.melt[i]);
}

}  // namespace thixo
