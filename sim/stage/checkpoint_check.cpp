#include "sim/stage/checkpoint_check.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>

#include "pipeline/base/error.h"
#include "sim/loop/step.h"

namespace thixo {
namespace {

// Coordinates and sizes beyond this are no scene's, and their squares no numbers [m].
constexpr Real kFarthest = Real(1e9);
constexpr double kLongest = 1e9;  // [s]
constexpr std::int64_t kMostIds = std::numeric_limits<std::int32_t>::max();
// Ids of surfels are multiplied by two when a surfel splits.
constexpr std::int64_t kLargestSurfelId = std::int64_t(1) << 61;

struct Check {
    const std::string& file;

    void require(bool right, const char* name, const char* why) const {
        if (!right) throw CacheError("{}: '{}' {}", file, name, why);
    }
    template <class T>
    void length(const char* name, const std::vector<T>& array, std::size_t rows) const {
        if (array.size() != rows)
            throw CacheError("{}: '{}' has {} rows where there are {}", file, name, array.size(), rows);
    }
    template <class T>
    void length_or_none(const char* name, const std::vector<T>& array, std::size_t rows) const {
        if (!array.empty()) length(name, array, rows);
    }
    template <class Table>
    void lengths(const Table& table, std::size_t rows) const {
        for_each_array(table, [&](const char* name, const auto& array) { length(name, array, rows); });
    }
    /// In from .. end - 1.
    void range(const char* name, std::int64_t n, std::int64_t from, std::int64_t end) const {
        if (n < from || n >= end)
            throw CacheError("{}: '{}' holds {}, which is not in {} to {}", file, name, n, from, end - 1);
    }
    template <class T>
    void range(const char* name, const std::vector<T>& array, std::int64_t from, std::int64_t end) const {
        for (const T v : array) range(name, static_cast<std::int64_t>(v), from, end);
    }
    template <class T>
    void ascends(const char* name, const std::vector<T>& array) const {
        require(std::ranges::adjacent_find(array, std::greater_equal<>()) == array.end(), name, "does not ascend");
    }
    template <class T, class Right>
    void values(const char* name, const std::vector<T>& array, const char* what, Right right) const {
        require(std::ranges::all_of(array, right), name, what);
    }
};

template <class T>
requires std::is_arithmetic_v<T> || std::is_enum_v<T>
bool is_finite(T v) {
    if constexpr (std::is_floating_point_v<T>) return std::isfinite(v);
    return true;
}
bool is_finite(const Vec3& v) { return v.allFinite(); }
bool is_finite(const Quad& q) { return xyz(q).allFinite() && std::isfinite(q.w); }
bool is_finite(const Symmetric& s) { return matrix(s).allFinite(); }
bool is_finite(const EdgeCut& c) {
    return std::isfinite(c.angle) && std::isfinite(c.along) && std::isfinite(c.across) &&
           std::isfinite(c.shift_angle) && std::isfinite(c.shift);
}

/// Every number of every array of a table.
template <class Table>
void check_finite(const Check& check, const Table& table) {
    for_each_array(table, [&](const char* name, const auto& array) {
        check.values(name, array, "holds what is no number", [](const auto& v) { return is_finite(v); });
    });
}

bool is_near(const Vec3& x) { return (x.array().abs() < kFarthest).all(); }
bool is_positive(Real v) { return v > 0 && v < kFarthest; }

void check_places(const Check& check, const char* name, const std::vector<Vec3>& places) {
    check.values(name, places, "lies beyond all scenes", is_near);
}

void check_unique(const Check& check, const char* name, std::vector<std::int64_t> ids) {
    std::ranges::sort(ids);
    check.require(std::ranges::adjacent_find(ids) == ids.end(), name, "holds one id twice");
}

void check_bodies(const Check& check, const Simulation& sim, const Solids& at_start) {
    const Solids& solids = sim.solids;
    const scene::Scene& scene = sim.problem.scene;
    const auto count = static_cast<std::int64_t>(solids.elements.size());
    std::vector<std::int64_t> ids;
    std::vector<Index> listed(solids.elements.size(), 0);
    check.require(!solids.bodies.empty() && solids.next_body >= at_start.next_body, "next_body",
                  "is below what the scene begins with");
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        ids.push_back(body.id);
        check.range("body.id", body.id, body.shaped() ? 0 : -1, solids.next_body);
        check.range("body.parent", body.parent, -1, solids.next_body);
        check.range("body.source", body.source, -1, static_cast<std::int64_t>(scene.bodies.size()));
        check.range("body.material", body.material, 0, static_cast<std::int64_t>(scene.materials.size()));
        check.require(is_near(body.origin), "body.origin", "lies beyond all scenes");
        // Shapes are not stored: the scene's belong to the bodies that it makes.
        const bool made = b < at_start.bodies.size() && at_start.bodies[b].source == body.source;
        check.require(made || !body.scene_shape, "body.scene_shape", "is told of a body that the scene does not make");
        check.ascends("body.elements", body.elements);
        check.range("body.elements", body.elements, 0, count);
        // A fragment that has melted goes back to the body that it came from.
        check.require(!body.shaped() || !body.empty() || body.parent >= 0, "body.elements", "is empty");
        check.range("body.cuts", body.cuts, 0, std::numeric_limits<std::int32_t>::max());
        if (!body.empty()) {
            check.range("body.typical", body.typical, 0, count);
            check.range("body.lightest", body.lightest, 0, count);
        }
        for (const Index i : body.elements) {
            check.require(solids.elements.owner[i] == static_cast<std::int32_t>(b), "body.elements",
                          "differs from 'solid.owner'");
            ++listed[i];
        }
    }
    check_unique(check, "body.id", std::move(ids));
    check.values("body.elements", listed, "leaves elements out", [](Index n) { return n == 1; });
    for (const Handle& handle : solids.handles) {
        check.ascends("handle.elements", handle.elements);
        check.range("handle.elements", handle.elements, 0, count);
        check.require(handle.mass >= 0 && std::isfinite(handle.mass), "handle.mass", "is no mass");
    }
}

/// Sizes of elements may differ from each other, as those of an octree do. Far from the scene's own they are nobody's: a
/// grid of such cells would have no end, nor would the sub-steps of such springs.
void check_sizes(const Check& check, const Simulation& sim) {
    constexpr Real kApart = 1e3;
    const Elements& e = sim.solids.elements;
    const auto require_like = [&](const char* name, const std::vector<Real>& array, Real usual, Real apart) {
        check.values(name, array, "is far from all sizes of the scene",
                     [=](Real v) { return v > usual / apart && v < usual * apart; });
    };
    const Real spacing = static_cast<Real>(sim.problem.scene.solver.spacing);
    require_like("solid.support", e.support, static_cast<Real>(sim.problem.smoothing.support), kApart);
    require_like("solid.volume", e.volume, cube(spacing), cube(kApart));
    for (Index i = 0; i < e.size(); ++i) {
        const Real integrates = e.quadrature[i];
        check.require(sim.solids.owner(i).rigid
                          ? integrates == 0
                          : integrates > cube(spacing / kApart) && integrates < cube(spacing * kApart),
                      "solid.quadrature", "is no volume of an element");
        const auto material = static_cast<std::size_t>(sim.solids.owner(i).material);
        const Real density = e.mass[i] / e.volume[i];
        const auto usual = sim.problem.materials[material].density;
        check.require(density > usual / kApart && density < usual * kApart, "solid.mass",
                      "gives no density of its material");
    }
}

/// What a scene makes of elements, and later steps do not change.
void check_elements(const Check& check, const Simulation& sim) {
    const Elements& e = sim.solids.elements;
    const std::size_t n = e.size();
    for_each_array_of(Life::made, e, [&](const char* name, const auto& array) {
        check.length(name, array, n);
        check.values(name, array, "holds what is no number", [](const auto& v) { return is_finite(v); });
    });
    std::vector<std::int64_t> ids = sim.particles.id;
    std::ranges::sort(ids);
    check.values("solid.id", e.id, "names a particle that is not there",
                 [&](std::int64_t id) { return std::ranges::binary_search(ids, id); });
    check_unique(check, "solid.id", e.id);
    check.range("solid.owner", e.owner, 0, static_cast<std::int64_t>(sim.solids.bodies.size()));
    for (Index i = 0; e.softens && i < n; ++i) check.require(e.law[i] == i, "solid.law", "is not every element's own");
    check.values("solid.rest", e.rest, "lies beyond all scenes", [](const Quad& q) { return is_near(xyz(q)); });
}

void check_bonds(const Check& check, const Bonds& bonds, std::size_t elements) {
    const std::size_t total = bonds.neighbour.size();
    check.length("bonds.begin", bonds.begin, elements + 1);
    check.require(bonds.begin.front() == 0 && bonds.begin.back() == total, "bonds.begin",
                  "does not span 'bonds.neighbour'");
    check.require(std::ranges::is_sorted(bonds.begin), "bonds.begin", "does not ascend");
    check.values("bonds.begin", bonds.begin, "divides lanes", [](std::size_t at) { return at % kLanes == 0; });
    check.range("bonds.neighbour", bonds.neighbour, 0, static_cast<std::int64_t>(elements));
    check.length("bonds.weight", bonds.weight, total);
    check.length("bonds.weight_back", bonds.weight_back, total);
    check.length_or_none("bonds.base", bonds.base, total);
    check.length("bonds.base_back", bonds.base_back, bonds.base.size());
    check.length_or_none("bonds.visibility", bonds.visibility, total);
    for (const auto& [name, array] : {std::pair("bonds.weight", &bonds.weight),
                                      {"bonds.weight_back", &bonds.weight_back},
                                      {"bonds.base", &bonds.base},
                                      {"bonds.base_back", &bonds.base_back}})
        check.values(name, *array, "holds what is no weight", [](Real w) { return w >= 0 && std::isfinite(w); });
    check.values("bonds.visibility", bonds.visibility, "is not between 0 and 1",
                 [](Real v) { return v >= 0 && v <= 1; });
    check.length("bonds.moment", bonds.moment, elements);
    std::vector<Index> flat;
    for (const auto& [i, projection] : bonds.flat) flat.push_back(i);
    check.ascends("bonds.flat", flat);
    check.range("bonds.flat", flat, 0, static_cast<std::int64_t>(elements));
    std::size_t thin = 0;
    for (const RestMoment& m : bonds.moment) thin += !m.full;
    check.require(thin == flat.size() && std::ranges::none_of(flat, [&](Index i) { return bonds.moment[i].full; }),
                  "bonds.flat", "differs from 'bonds.moment'");
}

void check_embedded(const Check& check, const Simulation& sim) {
    const EmbeddedSurface& e = sim.embedded;
    check.lengths(e, e.size());
    check_finite(check, e);
    for (const auto& [name, array] : {std::pair("embedded.place", &e.rest.position),
                                      {"embedded.axis1", &e.rest.axis1},
                                      {"embedded.axis2", &e.rest.axis2},
                                      {"embedded.first", &e.first}})
        check_places(check, name, *array);
    check.require(e.size() == 0 || sim.problem.scene.surface.enabled, "embedded.owner",
                  "is of a scene without surface");
    check.range("embedded.owner", e.owner, 0, static_cast<std::int64_t>(sim.solids.bodies.size()));
    check.values("embedded.owner", e.owner, "names a body without rest shape",
                 [&](std::int32_t owner) { return sim.solids.bodies[static_cast<std::size_t>(owner)].shaped(); });
    check.range("embedded.sheet", e.sheet, 0, std::numeric_limits<std::int32_t>::max());
    check.range("embedded.beyond", e.beyond, 0, 2);
    std::vector<Index> first;
    std::vector<std::int64_t> ids;
    for (const SurfelFamily& f : e.families) {
        first.push_back(f.first);
        ids.insert(ids.end(), {f.base, f.shift});
    }
    check.ascends("embedded.families", first);
    check.range("embedded.families", first, 0, static_cast<std::int64_t>(e.size()) + 1);
    check.range("embedded.families", ids, -kLargestSurfelId, kLargestSurfelId);
    check.require(e.size() == 0 || (!first.empty() && first.front() == 0), "embedded.families", "leaves surfels out");
}

void check_contacts(const Check& check, const Solids& solids, std::size_t walls) {
    const ContactNodes& c = solids.contacts.nodes;
    check.lengths(c, c.size());
    check_finite(check, c);
    const auto key = [&](std::size_t k) { return std::tuple(c.sample[k], c.partner[k], c.first[k], c.second[k]); };
    const std::size_t samples = solids.contacts.samples.size(), elements = solids.elements.size();
    check.range("contact.partner", c.partner, -static_cast<std::int64_t>(walls),
                static_cast<std::int64_t>(solids.bodies.size()));
    for (std::size_t k = 0; k < c.size(); ++k) {
        check.require(k == 0 || key(k - 1) < key(k), "contact.sample", "does not ascend with its ends");
        const bool between_elements = c.sample[k] == kNone;
        check.require(between_elements || c.sample[k] < samples, "contact.sample", "names a sample that is not there");
        for (const auto& [name, end] : {std::pair("contact.first", c.first[k]), {"contact.second", c.second[k]}})
            check.require(between_elements ? end < elements : end == kNone, name, "names an element that is not there");
    }
}

/// Every particle that an own stress moves has an element, and they agree on its phase.
void check_phases(const Check& check, const Simulation& sim) {
    const Particles& p = sim.particles;
    const Elements& e = sim.solids.elements;
    for (std::size_t k = 0; k < p.size(); ++k) {
        const Index i = sim.solids.element(p.id[k]);
        check.require(i != kNone || !is_elastic(p.phase[k]), "phase", "is a solid's where there is no solid");
        if (i == kNone) continue;
        check.require(e.phase_of(i) == p.phase[k], e.softens ? "solid.phase" : "phase",
                      "differs between a particle and its element");
    }
}

void check_softening(const Check& check, const Simulation& sim) {
    const Solids& solids = sim.solids;
    const std::size_t bodies = solids.bodies.size();
    check.length("solid.rest", solids.elements.rest, solids.elements.size());
    check.length("solid.depth", solids.elements.depth, solids.elements.size());
    check.values("solid.rest", solids.elements.rest, "lies beyond all scenes",
                 [](const Quad& q) { return is_near(xyz(q)) && is_finite(q); });
    check.length_or_none("solid.laws", solids.laws, bodies);
    check.length_or_none("solid.rates", solids.rates, bodies);
    const bool current = solids.rates_version == solids.elements.bonds.version;
    check.require(!current || solids.laws.size() == bodies, "solid.laws", "is not there for the rates of now");
    check.require(!current || sim.problem.strategy.implicit_solids || solids.rates.size() == bodies, "solid.rates",
                  "is not there for the laws of now");
    check.values("solid.laws", solids.laws, "has a direction, which matter that melts has not",
                 [](const StressLaw& law) { return law.anisotropy == kNone; });
    check.length("solid.flow", solids.softening.flow.plastic, solids.elements.size());
    check.values("solid.flow", solids.softening.flow.plastic, "holds what is no number",
                 [](const Symmetric& v) { return is_finite(v); });
}

void check_surface(const Check& check, const SurfaceState& surface, const Simulation& sim) {
    check.lengths(surface, surface.size());
    check_finite(check, surface);
    check_places(check, "position", surface.surfels.position);
    check_places(check, "axis1", surface.surfels.axis1);
    check_places(check, "axis2", surface.surfels.axis2);
    check_unique(check, "id", surface.id);
    check.range("id", surface.id, 0, kLargestSurfelId);
    check.range("next_id", surface.next_id, 0, kLargestSurfelId);
    check.values("lift", surface.lift, "holds what is no length", [](Real v) { return std::abs(v) < kFarthest; });
    check.require(surface.lift.size() <= sim.problem.scene.materials.size(), "lift", "has more rows than materials");
    check.range("unmeasured", surface.unmeasured, 0, std::numeric_limits<std::int32_t>::max());
}

/// Ids of all bodies, ascending: those that the scene makes, and those that have split off.
std::vector<std::int32_t> body_ids(const Simulation& sim) {
    std::vector<std::int32_t> ids;
    const std::size_t made = sim.problem.scene.bodies.size() + sim.problem.scene.emitters.size();
    for (std::size_t b = 0; b < made; ++b) ids.push_back(static_cast<std::int32_t>(b));
    for (const SolidBody& body : sim.solids.bodies)
        if (body.shaped()) ids.push_back(body.id);
    std::ranges::sort(ids);
    return ids;
}

void check_body_ids(const Check& check, const char* name, const std::vector<std::int32_t>& array,
                    const std::vector<std::int32_t>& ids) {
    check.values(name, array, "names a body that is not there",
                 [&](std::int32_t id) { return std::ranges::binary_search(ids, id); });
}

}  // namespace

void check_clock(const Simulation& sim, const std::string& file) {
    const Check check{file};
    const Clock& c = sim.clock;
    const scene::Frames& frames = sim.problem.scene.frames;
    check.range("frame", c.frame, frames.first, std::numeric_limits<int>::max());
    check.range("step", c.step, 0, std::numeric_limits<std::int64_t>::max() / 2);
    check.require(c.time >= frame_time(frames, c.frame) && c.time < kLongest, "time", "is not that of the frame");
    check.require(c.last_dt >= 0 && c.last_dt <= c.time, "last_dt", "is longer than the run");
    for (std::size_t k = 0; k < sim.emitters.size(); ++k) {
        const EmitterState& e = sim.emitters[k];
        const scene::Emitter& source = sim.problem.scene.emitters[k];
        check.require(e.layer >= 0 && e.blocked >= 0, "layer", "is below zero");
        check.require(e.next >= source.start && std::isfinite(e.next), "next", "is before the source starts");
        // The last step released what was due at its start.
        const double begun = c.time - c.last_dt * (1 + 1e-6) - 1e-9 * c.time;
        check.require(c.step == 0 || e.next >= source.stop || e.next >= begun, "next", "is long past");
    }
}

void check_particles(const Simulation& sim, const std::string& file) {
    const Check check{file};
    const Particles& p = sim.particles;
    check.lengths(p, p.size());
    check_finite(check, p);
    check.range("next_id", sim.next_id, static_cast<std::int64_t>(p.size()), kMostIds);
    check.range("id", p.id, 0, sim.next_id);
    check_unique(check, "id", p.id);
    check.range("material", p.material, 0, static_cast<std::int64_t>(sim.problem.scene.materials.size()));
    check.range("phase", p.phase, 0, static_cast<std::int64_t>(Phase::viscoelastic) + 1);
    check_places(check, "position", p.position);
    check_places(check, "surface_position", p.surface_position);
    check.values("mass", p.mass, "holds what is no mass", is_positive);
    check.values("rest_volume", p.rest_volume, "holds what is no volume", is_positive);
    if (p.has.spacing) check.values("spacing", p.spacing, "holds what is no length", is_positive);
    check.values("melt", p.melt, "is not between 0 and 1", [](Real b) { return b >= 0 && b <= 1; });
}

void check_altered(const Simulation& sim, const Solids& at_start, const std::string& file) {
    const Check check{file};
    check_elements(check, sim);
    check_bodies(check, sim, at_start);
    check_sizes(check, sim);
    check_bonds(check, sim.solids.elements.bonds, sim.solids.elements.size());
    check_embedded(check, sim);
    check_cracks(sim, file);
}

void check_solids(const Simulation& sim, const std::string& file) {
    const Check check{file};
    const Solids& solids = sim.solids;
    check_body_ids(check, "body", sim.particles.body, body_ids(sim));
    for_each_array_of(Life::state, solids.elements, [&](const char* name, const auto& array) {
        check.length(name, array, solids.elements.size());
        check.values(name, array, "holds what is no number", [](const auto& v) { return is_finite(v); });
    });
    check_phases(check, sim);
    check.values("solid.displacement", solids.elements.displacement, "lies beyond all scenes",
                 [](const Quad& q) { return is_near(xyz(q)); });
    for (const SolidBody& body : solids.bodies) {
        check.range("body.skin", static_cast<std::int64_t>(body.skin), 0, static_cast<std::int64_t>(Skin::rebound) + 1);
        check.require(!body.refrozen || (solids.softening.any && !body.empty()), "body.refrozen",
                      "is told of what cannot freeze");
        check.require(body.skin != Skin::rebound || body.refrozen, "body.skin",
                      "is bound to a shape that is not there");
        check.require((body.turn.transpose() * body.turn - Mat3d::Identity()).norm() < 1e-3, "body.turn",
                      "is no rotation");
        check.require(is_near(body.place.cast<Real>()), "body.place", "lies beyond all scenes");
    }
    for (const Handle& handle : solids.handles)
        check.length_or_none("solid.anchor", handle.anchor, handle.elements.size());
    if (solids.empty()) return;
    check.require(solids.last_dt >= 0 && solids.last_dt <= sim.clock.time, "solid.last_dt", "is longer than the run");
    check.require(solids.stretch2 >= 0 && std::isfinite(solids.stretch2), "solid.stretch2", "is no stretch");
    check.require(std::isfinite(solids.stiffening), "solid.stiffening", "is no stiffness");
    if (solids.elements.breaks) {
        check.require(solids.cracks.step > 0, "cracks.step", "is no time");
        check.require(solids.cracks.load >= 0, "cracks.load", "is no share of a strength");
        check_blades(sim, file);
        check.length_or_none("cracks.laws", solids.laws, solids.bodies.size());
        check.length_or_none("cracks.rates", solids.rates, solids.bodies.size());
    }
    check_contacts(check, solids, sim.walls.list.size());
    if (solids.softening.any) check_softening(check, sim);
}

void check_surfaces(const Simulation& sim, const std::string& file) {
    const Check check{file};
    const std::vector<std::int32_t> ids = body_ids(sim);
    check_surface(check, sim.surface, sim);
    check_body_ids(check, "body", sim.surface.body, ids);
    if (sim.solids.empty()) return;
    const MixedSurface& mixed = sim.mixed_surface;
    check_surface(check, mixed.animated, sim);
    check_body_ids(check, "body", mixed.animated.body, ids);
    check.lengths(mixed.zombies, mixed.zombies.size());
    check_finite(check, mixed.zombies);
    check_places(check, "zombie.position", mixed.zombies.position);
    check.range("zombie.component", mixed.zombies.component, 0,
                static_cast<std::int64_t>(sim.problem.scene.materials.size()));
    check_body_ids(check, "zombie.body", mixed.zombies.body, ids);
    check.lengths(mixed.refrozen, mixed.refrozen.size());
    check_finite(check, mixed.refrozen);
    check.ascends("refrozen.id", mixed.refrozen.id);
    check_places(check, "refrozen.place", mixed.refrozen.place);
    check_places(check, "refrozen.axis1", mixed.refrozen.axis1);
    check_places(check, "refrozen.axis2", mixed.refrozen.axis2);
}

}  // namespace thixo
