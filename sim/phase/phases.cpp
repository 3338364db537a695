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

/// Lists the rest neighbours of the elements marked by 1 anew; other lists stay. Bonds that persist keep their
/// visibility; new ones are visible.
void list_neighbours_anew(const std::vector<std::uint8_t>& which, Solids& solids) {
    Bonds& bonds = solids.elements.bonds;
    const Bonds old = bonds;
    find_rest_neighbours(solids.bodies, solids.elements, hang_together_in_shapes(solids));
    keep_bases(bonds);
    const Bonds fresh = bonds;
    const std::size_t n = which.size();
    const auto list_of = [&](std::size_t i) -> const Bonds& { return which[i] ? fresh : old; };
    for (std::size_t i = 0; i < n; ++i)
        bonds.begin[i + 1] = bonds.begin[i] + (list_of(i).begin[i + 1] - list_of(i).begin[i]);
    const auto copy = [&](auto array) {
        (bonds.*array).assign(bonds.begin[n], {});
        parallel_for(n, [&](std::size_t i) {
            const Bonds& from = list_of(i);
            std::copy((from.*array).begin() + static_cast<std::ptrdiff_t>(from.begin[i]),
                      (from.*array).begin() + static_cast<std::ptrdiff_t>(from.begin[i + 1]),
                      (bonds.*array).begin() + static_cast<std::ptrdiff_t>(bonds.begin[i]));
        });
    };
    copy(&Bonds::neighbour);
    for (const auto array : {&Bonds::weight, &Bonds::weight_back, &Bonds::base, &Bonds::base_back}) copy(array);
    if (old.visibility.empty()) return;
    bonds.visibility.assign(bonds.neighbour.size(), 1);
    parallel_for(n, [&](std::size_t i) {
        const auto first = old.neighbour.begin() + static_cast<std::ptrdiff_t>(old.begin[i]),
                   last = old.neighbour.begin() + static_cast<std::ptrdiff_t>(old.begin[i + 1]);
        for (std::size_t k = bonds.begin[i]; k < bonds.begin[i + 1]; ++k)
            if (const auto found = std::find(first, last, bonds.neighbour[k]); found != last)
                bonds.visibility[k] = old.visibility[static_cast<std::size_t>(found - old.neighbour.begin())];
    });
    weigh_bonds(solids.elements, kThin);
}

void find_neighbours_of(const std::vector<std::uint8_t>& bodies, Solids& solids) {
    Elements& e = solids.elements;
    std::vector<std::uint8_t> which(e.size());
    for (std::size_t i = 0; i < e.size(); ++i) which[i] = bodies[static_cast<std::size_t>(e.owner[i])];
    list_neighbours_anew(which, solids);
    measure_moments(e, &which, kThin);
}

/// A number for the frame of a new rest shape.
std::int32_t new_frame(const Solids& solids) {
    std::int32_t last = 0;
    for (const SolidBody& body : solids.bodies) last = std::max({last, body.frame, body.source});
    for (const Breaking& breaking : solids.breaking) last = std::max(last, breaking.frame);
    return last + 1;
}

/// Cracks are gone between elements that have both melted.
void heal_cracks(const std::vector<std::uint8_t>& melted, Solids& solids) {
    Bonds& bonds = solids.elements.bonds;
    if (bonds.visibility.empty()) return;
    parallel_for(bonds.size(), [&](std::size_t i) {
        for (std::size_t k = bonds.begin[i]; melted[i] && k < bonds.begin[i + 1]; ++k)
            if (melted[bonds.neighbour[k]]) bonds.visibility[k] = 1;
    });
}

/// Sheets are places of the rest shape of before: they weaken no bond of the body any more.
void leave_sheets(const Solids& solids, const SolidBody& body, BondCrossings& crossings) {
    std::vector<Index> rows;
    for (Index k = 0; k < crossings.size(); ++k)
        if (&solids.owner(crossings.first[k]) != &body) rows.push_back(k);
    keep_table_rows(crossings, rows);
}

/// Refreezes bodies that are solid throughout, but not wholly bound to a rest shape or to its surface.
void refreeze(Particles& particles, Solids& solids, std::vector<std::uint8_t>& changed) {
    const Elements& e = solids.elements;
    std::vector<std::uint8_t> refrozen(solids.bodies.size(), 0), melted;
    bool any = false;
    for (SolidBody& body : solids.bodies) {
        const bool solid = body.shaped() && std::ranges::all_of(body.elements, [&](Index i) { return e.melt[i] == 0; });
        // What has only softened has left no rest shape. But its surface is that of a liquid, and no crack would run.
        const bool softened = e.breaks && body.skin == Skin::animated && !body.refrozen && !body.empty();
        const bool flowed =
            std::ranges::any_of(body.elements, [&](Index i) { return e.phase[i] == Phase::viscoelastic; });
        if (!solid || !(flowed || softened)) continue;
        if (!any) {
            find_gradients(e, solids.gradients);
            melted.resize(e.size());
            for (std::size_t i = 0; i < e.size(); ++i) melted[i] = e.phase[i] != Phase::solid;
        }
        any = true;
        const auto b = static_cast<std::size_t>(&body - solids.bodies.data());
        refrozen[b] = changed[b] = 1;
        take_shape(body, particles, solids);
        body.refrozen = true;
        body.shape.reset();
        leave_sheets(solids, body, solids.cracks.crossings);
        body.frame = new_frame(solids);
        solids.altered = solids.altered || e.breaks;
    }
    if (!any) return;
    heal_cracks(melted, solids);
    find_neighbours_of(refrozen, solids);
}

/// Rigid pieces that begin to melt are elastic again.
void release_rigid(Solids& solids) {
    Elements& e = solids.elements;
    for (SolidBody& body : solids.bodies) {
        if (!body.rigid || solids.solid_throughout(body)) continue;
        body.rigid = false;
        for (const Index i : body.elements) e.quadrature[i] = e.volume[i];
        e.bonds.changed();
    }
}

/// A fragment that is liquid throughout is matter of the body of the scene that it came from again, where that melts,
/// too. A crumb that melts beside a cold body would take its shape from it.
void return_fragments(Particles& particles, Solids& solids, std::vector<std::uint8_t>& changed) {
    Elements& e = solids.elements;
    for (SolidBody& body : solids.bodies) {
        if (body.parent < 0 || body.empty() || body.skin != Skin::animated) continue;
        if (std::ranges::any_of(body.elements, [&](Index i) { return e.phase[i] != Phase::liquid; })) continue;
        const auto root = std::ranges::find_if(
            solids.bodies, [&](const SolidBody& b) { return b.parent < 0 && b.source == body.source; });
        if (root->skin != Skin::animated || solids.solid_throughout(*root)) continue;
        const auto to = root - solids.bodies.begin();
        changed[static_cast<std::size_t>(&body - solids.bodies.data())] = changed[static_cast<std::size_t>(to)] = 1;
        body.shape.reset();
        for (const Index i : std::exchange(body.elements, {})) {
            e.owner[i] = static_cast<std::int32_t>(to);
            particles.body[solids.particle_of[i]] = root->id;
            root->elements.push_back(i);
        }
        std::ranges::sort(root->elements);
        solids.altered = true;
    }
}

}  // namespace

void find_refrozen_neighbours(Solids& solids) {
    if (std::ranges::none_of(solids.bodies, &SolidBody::refrozen)) return;
    std::vector<std::uint8_t> refrozen;
    for (const SolidBody& body : solids.bodies) refrozen.push_back(body.refrozen);
    find_neighbours_of(refrozen, solids);
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
        solids.bodies.push_back({.id = -1, .source = -1, .frame = -1, .material = material});
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
        if (e.breaks) e.strength[i] = e.own_strength[i] = kUnbreakable;
        emitted->elements.push_back(i);
        solids.softening.flow.plastic.push_back({});
        solids.particle_of.push_back(k);
        number_element(id, i, solids);
    }
}

std::vector<std::uint8_t> change_phases(const Materials& materials, const Outside& outside, double last_dt,
                                        Particles& particles, Solids& solids) {
    Softening& s = solids.softening;
    if (!s.any) return {};
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
    release_rigid(solids);
    std::vector<std::uint8_t> changed(solids.bodies.size(), 0);
    return_fragments(particles, solids, changed);
    seed_flow(seeds, solids);
    refreeze(particles, solids, changed);
    s.freezes = s.moves = false;
    for (std::size_t i = 0; i < e.size(); ++i) {
        s.freezes = s.freezes || e.phase[i] == Phase::viscoelastic || (e.phase[i] == Phase::solid && e.melt[i] > 0);
        s.moves = s.moves || is_elastic(e.phase[i]);
    }
    const bool bind = e.breaks && std::ranges::any_of(changed, [](std::uint8_t c) { return c != 0; });
    return bind ? changed : std::vector<std::uint8_t>();
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
