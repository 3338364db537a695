#include "sim/solid/phases.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/parallel.h"
#include "sim/solid/melt_stencils.h"
#include "sim/solid/rest_shape.h"
#include "sim/solid/solids.h"
#include "sim/solid/stable_step.h"

namespace thixo {
namespace {

const scene::Material& material_of(const scene::Scene& scene, const Particles& p, std::size_t k) {
    return scene.materials[static_cast<std::size_t>(p.material[k])];
}

/// Room for one more element of every array of phases.
void append_phase(Phases& s, Bond bond, Real melt) {
    s.bond.push_back(bond);
    s.melt.push_back(melt);
    s.flow.plastic.push_back({});
}

Bond first_bond(const scene::Material& m, Real b) {
    return b < 1 ? Bond::rest : keeps_shape(m, static_cast<double>(b)) ? Bond::flowing : Bond::none;
}

/// A particle that has just become matter with a shape: its element is where the particle is.
void enter_solid(const Particles& p, std::size_t k, Index i, Solids& solids) {
    Elements& e = solids.elements;
    const SolidBody& body = solids.bodies[static_cast<std::size_t>(e.owner[i])];
    const Vec3d y = body.turn.transpose() * (p.position[k].cast<double>() - body.place);
    e.displacement[i] = quad((y - xyz(e.rest[i]).cast<double>()).cast<Real>());
    e.velocity[i] = quad((body.turn.transpose() * p.velocity[k].cast<double>()).cast<Real>());
    e.acceleration[i] = Vec3::Zero();
    solids.phases.flow.plastic[i] = {};
}

/// One particle's phase.
void change_phase(const scene::Material& m, const Vec3& half_fall, const Vec3& gravity, std::size_t k, Index i,
                  Particles& p, Solids& solids, std::vector<std::uint8_t>& seeds) {
    Phases& s = solids.phases;
    const Real before = p.melt[k];
    const Real b = static_cast<Real>(m.melting.fraction(p.temperature[k]));
    p.melt[k] = s.melt[i] = b;
    const bool shape = keeps_shape(m, static_cast<double>(b));
    if (s.bond[i] == Bond::none && shape) {
        // The velocity of a solid particle lacks half a step of the liquid's push, but none of gravity (sim/step).
        p.velocity[k] += half_fall;
        p.acceleration[k] -= gravity;
        p.kind[k] = Kind::solid;
        loosen(solids, i);
        enter_solid(p, k, i, solids);
    } else if (s.bond[i] != Bond::none && !shape) {
        p.velocity[k] -= half_fall;
        p.acceleration[k] += gravity;
        p.kind[k] = Kind::liquid;
        s.bond[i] = Bond::none;
    } else if (s.bond[i] == Bond::rest && b >= 1) {
        loosen(solids, i);
    } else if (s.bond[i] == Bond::rest && b > 0 && before == 0) {
        seeds[i] = 1;
    }
}

}  // namespace

void loosen(Solids& solids, std::size_t i) {
    solids.phases.bond[i] = Bond::flowing;
    solids.elements.depth[i] = std::cbrt(solids.elements.volume[i]) / 2;
}

namespace {

/// The present shape of a body becomes its rest shape.
void take_shape(const SolidBody& body, Solids& solids) {
    Phases& s = solids.phases;
    Elements& e = solids.elements;
    const Mat3 turn = body.turn.cast<Real>();
    for (Index i = body.begin; i < body.end; ++i) {
        Mat3 strain;  // minus the elastic one
        if (s.bond[i] == Bond::flowing) {
            strain = turn.transpose() * matrix(s.flow.plastic[i]) * turn;
        } else {
            const Mat3 q = rotation_of(Mat3::Identity() + solids.gradients[i]);
            strain = q * (matrix(e.plastic[i]) - matrix(strain_of(e, i, solids.gradients[i]))) * q.transpose();
        }
        e.plastic[i] = symmetric(strain);
        const Real stiffness = e.rest[i].w;
        e.rest[i] = quad(xyz(e.rest[i]) + xyz(e.displacement[i]), stiffness);
        e.displacement[i] = quad(Vec3::Zero());
        s.bond[i] = Bond::rest;
    }
}

/// Bodies that are solid throughout, but not all of it bound to a rest shape.
void refreeze(Solids& solids) {
    Phases& s = solids.phases;
    bool any = false;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        bool solid = body.body >= 0, loose = false;
        for (Index i = body.begin; i < body.end && solid; ++i) {
            solid = s.melt[i] == 0;
            loose = loose || s.bond[i] == Bond::flowing;
        }
        if (!solid || !loose) continue;
        if (!any) find_gradients(solids.elements, solids.gradients);
        any = true;
        take_shape(body, solids);
        s.refrozen[b] = 1;
    }
    if (any) find_refrozen_neighbours(solids);
}

}  // namespace

void find_refrozen_neighbours(Solids& solids) {
    Phases& s = solids.phases;
    Elements& e = solids.elements;
    if (!s.any || std::ranges::none_of(s.refrozen, [](std::uint8_t r) { return r != 0; })) return;
    find_rest_neighbours(solids.bodies, e, hang_together_in_shapes(solids));
    s.weight = e.weight;
    s.weight_back = e.weight_back;
    std::vector<std::uint8_t> which(e.size());
    for (std::size_t i = 0; i < e.size(); ++i) which[i] = s.refrozen[static_cast<std::size_t>(e.owner[i])];
    measure_moments(e, &which, kThin);
    solids.laws.clear();  // rates are to be found anew
}

void make_phases(const scene::Scene& scene, const Smoothing& smoothing, const Particles& particles, Solids& solids) {
    Phases& s = solids.phases;
    const auto elastic = [&](const std::string& name, bool melting) {
        return std::ranges::any_of(scene.materials, [&](const scene::Material& m) {
            return m.name == name && m.elastic.solid() && (!melting || m.melting.any());
        });
    };
    const bool emitted = std::ranges::any_of(scene.emitters, [&](const auto& e) { return elastic(e.material, false); });
    s.any = emitted || std::ranges::any_of(scene.bodies, [&](const auto& b) { return elastic(b.material, true); });
    if (!s.any) return;
    Elements& e = solids.elements;
    if (e.begin.empty()) e.begin.push_back(0);
    for (std::size_t k = 0; k < particles.size(); ++k) {
        const Index i = solids.element(particles.id[k]);
        if (i == kNone) continue;
        if (s.bond.size() <= i) {
            s.bond.resize(e.size(), Bond::rest);
            s.melt.resize(e.size(), 0);
        }
        s.melt[i] = particles.melt[k];
        s.bond[i] = first_bond(material_of(scene, particles, k), particles.melt[k]);
    }
    s.flow.plastic.resize(e.size());
    s.weight = e.weight;
    s.weight_back = e.weight_back;
    e.law.resize(e.size());
    std::iota(e.law.begin(), e.law.end(), Index(0));
    if (emitted) {
        std::int32_t material = 0;
        for (std::size_t m = 0; m < scene.materials.size(); ++m)
            for (const scene::Emitter& from : scene.emitters)
                if (from.material == scene.materials[m].name && scene.materials[m].elastic.solid())
                    material = static_cast<std::int32_t>(m);
        const auto end = static_cast<Index>(e.size());
        solids.bodies.push_back(
            {.body = -1, .material = material, .begin = end, .end = end, .typical = end, .lightest = end});
    }
    s.refrozen.assign(solids.bodies.size(), 0);
    calibrate_rates(smoothing, s);
}

void adopt_particles(const scene::Scene& scene, const Smoothing& smoothing, const Particles& particles,
                     Solids& solids) {
    if (!solids.phases.any || solids.bodies.back().body >= 0) return;
    std::vector<std::pair<std::int64_t, Index>> found;
    for (Index k = 0; k < particles.size(); ++k)
        if (material_of(scene, particles, k).elastic.solid() && solids.element(particles.id[k]) == kNone)
            found.emplace_back(particles.id[k], k);
    std::ranges::sort(found);
    Elements& e = solids.elements;
    for (const auto& [id, k] : found) {
        const auto i = static_cast<Index>(e.size());
        e.id.push_back(id);
        e.owner.push_back(static_cast<std::int32_t>(solids.bodies.size() - 1));
        e.law.push_back(i);
        // What an emitter releases has no rest shape: its place there is the frame's origin.
        e.rest.push_back(quad(Vec3::Zero()));
        e.mass.push_back(particles.mass[k]);
        e.volume.push_back(particles.rest_volume[k]);
        e.support.push_back(smoothing.support);
        e.depth.push_back(smoothing.spacing / 2);
        e.moment.push_back(RestMoment{.inverse = {}, .full = false});
        e.flat.emplace_back(i, Symmetric{});
        e.begin.push_back(e.begin.back());
        e.displacement.push_back(quad(Vec3::Zero()));
        e.velocity.push_back(quad(Vec3::Zero()));
        e.acceleration.push_back(Vec3::Zero());
        e.plastic.push_back({});
        append_phase(solids.phases, Bond::none, 1);
        if (solids.element_of.size() <= static_cast<std::size_t>(id))
            solids.element_of.resize(static_cast<std::size_t>(id) + 1, kNone);
        solids.element_of[static_cast<std::size_t>(id)] = i;
    }
    solids.bodies.back().end = static_cast<Index>(e.size());
}

void change_phases(const scene::Scene& scene, const Vec3& gravity, double last_dt, Particles& particles,
                   Solids& solids) {
    Phases& s = solids.phases;
    if (!s.any) return;
    const Vec3 half_fall = static_cast<Real>(0.5 * last_dt) * gravity;
    std::vector<std::uint8_t> seeds(solids.elements.size(), 0);
    parallel_for(
        particles.size(),
        [&](std::size_t k) {
            const Index i = solids.element(particles.id[k]);
            if (i == kNone) return;
            const scene::Material& m = material_of(scene, particles, k);
            if (m.melting.any()) return change_phase(m, half_fall, gravity, k, i, particles, solids, seeds);
            if (s.bond[i] != Bond::none) return;
            // An emitter has released it: elastic, but with no shape of its own.
            particles.velocity[k] += half_fall;
            particles.acceleration[k] -= gravity;
            particles.kind[k] = Kind::solid;
            loosen(solids, i);
            enter_solid(particles, k, i, solids);
        },
        1024);
    seed_flow(seeds, solids);
    refreeze(solids);
    s.freezes = false;
    for (std::size_t i = 0; i < s.bond.size(); ++i)
        s.freezes = s.freezes || s.bond[i] == Bond::flowing || (s.bond[i] == Bond::rest && s.melt[i] > 0);
    s.moves = std::ranges::any_of(s.bond, [](Bond b) { return b != Bond::none; });
}

const std::vector<StressLaw>& stencil_laws(const Solids& solids) {
    return solids.phases.any ? solids.phases.kept : solids.laws;
}

StressLaw contact_law(const Solids& solids, std::size_t i) {
    const Phases& s = solids.phases;
    if (!s.any) return solids.laws[static_cast<std::size_t>(solids.elements.owner[i])];
    return scaled(s.whole[i], 1 - s.melt[i]);
}

}  // namespace thixo
