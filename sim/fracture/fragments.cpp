#include "sim/fracture/fragments.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/error.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/bonds/gradients.h"
#include "sim/bonds/members.h"
#include "sim/contact/contact.h"

namespace thixo {
namespace {

std::vector<std::uint8_t> marked(const Solids& solids, std::initializer_list<std::size_t> bodies) {
    std::vector<std::uint8_t> marks(solids.bodies.size(), 0);
    for (const std::size_t b : bodies) marks[b] = 1;
    return marks;
}

/// Throws where a split of body `b` would leave one side without elements.
void refuse_empty_side(std::size_t b, const std::function<bool(const Vec3&)>& goes, const Solids& solids) {
    const SolidBody& body = solids.bodies[b];
    const auto going = static_cast<std::size_t>(
        std::ranges::count_if(body.elements, [&](Index i) { return goes(xyz(solids.elements.rest[i])); }));
    if (going == 0 || going == body.size())
        throw InputError("body {} of {} particles is not split: {} of them would leave it; both sides need matter",
                         body.id, body.size(), going);
}

/// Appends a new body without elements, otherwise equal to body `b`.
std::size_t append_fragment(std::size_t b, Solids& solids) {
    SolidBody fragment = solids.bodies[b];
    fragment.elements.clear();
    fragment.parent = fragment.id;
    fragment.id = solids.next_body++;
    solids.bodies.push_back(std::move(fragment));
    // These tables have a row for each body at the present time. The next step computes them anew.
    if (!solids.laws.empty()) solids.laws.push_back(StressLaw(solids.laws[b]));
    if (!solids.rates.empty()) solids.rates.push_back(FastestRates(solids.rates[b]));
    solids.contacts.samples.first.push_back(solids.contacts.samples.first.back());
    solids.altered = true;
    return solids.bodies.size() - 1;
}

/// Moves elements, their particles and the surfels about them from one body to another.
void move_matter(std::size_t from, std::size_t to, const std::function<bool(const Vec3&)>& goes, const Matter& matter) {
    Solids& solids = matter.solids;
    Elements& e = solids.elements;
    SolidBody &old = solids.bodies[from], &now = solids.bodies[to];
    std::vector<Index> stays;
    for (const Index i : old.elements) {
        if (!goes(xyz(e.rest[i]))) {
            stays.push_back(i);
            continue;
        }
        now.elements.push_back(i);
        e.owner[i] = static_cast<std::int32_t>(to);
        matter.particles.body[solids.particle_of[i]] = now.id;
    }
    old.elements = std::move(stays);
    EmbeddedSurface& s = matter.embedded;
    for (std::size_t i = 0; i < s.size(); ++i)
        if (s.owner[i] == static_cast<std::int32_t>(from) && goes(s.rest.position[i]))
            s.owner[i] = static_cast<std::int32_t>(to);
}

/// Ends bonds at a split. Neither side has the scene's shape any more.
void part(std::size_t a, std::size_t b, const Matter& matter) {
    part_bonds(matter.solids.elements);
    for (const std::size_t k : {a, b}) matter.solids.bodies[k].scene_shape = false;
    bind_matter(marked(matter.solids, {a, b}), matter);
}

/// The surfels of a face, turned round for the body on its other side.
SurfelCloud turned(SurfelCloud face) {
    for (Vec3& n : face.normal) n = -n;
    face.axis1.swap(face.axis2);
    return face;
}

/// The part of the cutter's surface that lies in the shape.
SurfelCloud cut_face(const Shape& cutter, const Shape& shape, double spacing, std::uint64_t seed) {
    const SampledSurface both = sample_surface(intersection_of({cutter, shape}), {.spacing = spacing, .seed = seed});
    SurfelCloud face;
    const Real near = static_cast<Real>(spacing) / 4;
    for (std::size_t k = 0; k < both.surfels.size(); ++k) {
        const Vec3& x = both.surfels.position[k];
        if (std::abs(cutter.distance(x)) > near || shape.distance(x) > -near) continue;
        if (both.surfels.normal[k].dot(cutter.gradient(x, near)) < Real(0.9)) continue;
        face.position.push_back(x);
        face.axis1.push_back(both.surfels.axis1[k]);
        face.axis2.push_back(both.surfels.axis2[k]);
        face.normal.push_back(both.surfels.normal[k]);
    }
    return face;
}

/// Appends a face to a body's surfels, as a family and a sheet of its own.
void append_face(const SurfelCloud& face, std::size_t b, std::int32_t sheet, const Matter& matter) {
    constexpr std::int64_t kFirst = std::int64_t(1) << 50, kFamily = std::int64_t(1) << 36;
    EmbeddedSurface& s = matter.embedded;
    const std::size_t first = s.size();
    const auto own = std::ranges::find(s.owner, static_cast<std::int32_t>(b));
    const Real temperature =
        own == s.owner.end() ? Real(0) : s.temperature[static_cast<std::size_t>(own - s.owner.begin())];
    append_surfels(face, matter.solids.bodies[b].origin, static_cast<std::int32_t>(b), s);
    for (std::size_t i = first; i < s.size(); ++i) {
        s.sheet[i] = sheet;
        s.temperature[i] = temperature;
    }
    const std::int64_t base = kFirst + kFamily * static_cast<std::int64_t>(s.families.size());
    s.families.push_back(
        {.first = static_cast<Index>(first), .base = base, .shift = static_cast<std::int64_t>(face.size()) - base});
    matter.solids.bodies[b].cuts.push_back(sheet);
}

/// Removes the nodes at these bodies: they are found anew, without memory. Nodes at samples of other bodies are
/// renumbered.
void forget_nodes(const std::vector<std::uint8_t>& bodies, const ContactSamples& before, Contacts& c) {
    const ContactNodes& old = c.nodes;
    std::vector<Index> rows;
    std::vector<Index> sample;
    for (Index k = 0; k < old.size(); ++k) {
        // Nodes between elements remember nothing that depends on their bodies.
        if (old.sample[k] == kNone) {
            rows.push_back(k);
            sample.push_back(kNone);
            continue;
        }
        const auto owner = static_cast<std::size_t>(before.owner[old.sample[k]]);
        if (bodies[owner] || bodies[static_cast<std::size_t>(old.partner[k])]) continue;
        rows.push_back(k);
        sample.push_back(old.sample[k] - before.first[owner] + c.samples.first[owner]);
    }
    ContactNodes remaining;
    resize_table(remaining, rows.size());
    for_each_pair(remaining, old, [&](auto& to, const auto& from) {
        for (std::size_t k = 0; k < rows.size(); ++k) to[k] = from[rows[k]];
    });
    remaining.sample = std::move(sample);
    c.nodes = std::move(remaining);
}

/// Keeps these elements, and the surfels bound to them. Bodies that lose an element must be bound anew.
void select_matter(const std::vector<Index>& rows, const Matter& matter) {
    const std::vector<Index> now = new_places(rows, matter.solids.elements.size());
    select_elements(rows, matter.solids);
    for (SurfelWeight& w : matter.embedded.weight) w.element = now[w.element];
}

}  // namespace

void bind_matter(const std::vector<std::uint8_t>& bodies, const Matter& matter) {
    Solids& solids = matter.solids;
    EmbeddedSurface& s = matter.embedded;
    if (s.size() > 0) bind_surfels(solids, bodies, s);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        SolidBody& body = solids.bodies[b];
        if (!bodies[b] || body.empty()) continue;
        choose_examples(solids.elements, matter.smoothing, body);
        if (!body.scene_shape) body.shape = shape_of_surfels(s, body, static_cast<std::int32_t>(b));
    }
    // A lone body meets nothing and has no samples. At its first split all bodies without samples get some.
    std::vector<std::uint8_t> sampled = bodies;
    const std::vector<Index>& first = solids.contacts.samples.first;
    for (std::size_t b = 0; b < bodies.size(); ++b)
        if (!sampled[b] && first[b] == first[b + 1]) sampled[b] = 1;
    const ContactSamples before = sample_bodies(sampled, matter.seed, solids);
    forget_nodes(sampled, before, solids.contacts);
}

std::size_t split_body(std::size_t b, const std::function<bool(const Vec3&)>& goes, const Matter& matter) {
    refuse_empty_side(b, goes, matter.solids);
    const std::size_t to = append_fragment(b, matter.solids);
    matter.embedded.trim.emplace_back();
    matter.embedded.grid.emplace_back();
    move_matter(b, to, goes, matter);
    part(b, to, matter);
    return to;
}

std::size_t cut_body(std::size_t b, const Shape& cutter, const Matter& matter) {
    Solids& solids = matter.solids;
    EmbeddedSurface& s = matter.embedded;
    if (s.size() == 0 || !solids.bodies[b].shape)
        throw InputError("body {} is not cut: it has no {}; only a body with both can be cut", solids.bodies[b].id,
                         s.size() == 0 ? "surfels" : "shape");
    const Vec3 origin = solids.bodies[b].origin;
    const auto goes = [&](const Vec3& m) { return cutter.distance(m + origin) < 0; };
    refuse_empty_side(b, goes, solids);
    const double width = std::cbrt(static_cast<double>(solids.elements.volume[solids.bodies[b].typical]));
    const SurfelCloud face = cut_face(cutter, *solids.bodies[b].shape,
                                      matter.surfel_spacing > 0 ? matter.surfel_spacing : width / 3, matter.seed);
    const std::size_t to = append_fragment(b, solids);
    s.trim.emplace_back();
    s.grid.emplace_back();
    move_matter(b, to, goes, matter);
    const std::int32_t sheet = s.sheet.empty() ? 1 : *std::ranges::max_element(s.sheet) + 1;
    append_face(face, to, sheet, matter);
    append_face(turned(face), b, sheet, matter);
    part(b, to, matter);
    return to;
}

Index add_element(std::size_t b, const NewElement& given, std::int64_t particle, const Matter& matter) {
    Solids& solids = matter.solids;
    Elements& e = solids.elements;
    SolidBody& body = solids.bodies[b];
    // The new element moves as the matter about it: by the nearest element's displacement and its gradient.
    const Index host = *std::ranges::min_element(body.elements, {},
                                                 [&](Index i) { return (xyz(e.rest[i]) - given.place).squaredNorm(); });
    const Vec3 way = given.place - xyz(e.rest[host]);
    const Mat3 h = gradient_of(e, host);
    const Index i = append_element(e, particle, static_cast<std::int32_t>(b));
    if (e.softens) {
        e.law[i] = i;
        e.phase[i] = e.phase[host];
        e.melt[i] = e.melt[host];
        solids.softening.flow.plastic.push_back(solids.softening.flow.plastic[host]);
    }
    e.rest[i] = quad(given.place, e.rest[host].w);
    e.mass[i] = given.mass;
    e.volume[i] = given.volume;
    e.support[i] = given.support;
    e.depth[i] = given.depth;
    e.displacement[i] = quad(xyz(e.displacement[host]) + h * way);
    e.velocity[i] = e.velocity[host];
    e.acceleration[i] = e.acceleration[host];
    e.plastic[i] = e.plastic[host];
    if (e.hardens) e.hardened[i] = e.hardened[host];
    body.elements.push_back(i);
    number_element(particle, i, solids);

    Particles& p = matter.particles;
    const Index from = solids.particle_of[host], k = append_row(p);
    for_each_array(p, [&](const char*, auto& array) { array[k] = array[from]; });
    p.id[k] = particle;
    p.mass[k] = given.mass;
    p.rest_volume[k] = given.volume;
    p.position[k] = (body.turn * (xyz(e.rest[i]) + xyz(e.displacement[i])).cast<double>() + body.place).cast<Real>();
    solids.particle_of.push_back(k);
    bond_element(i, solids);
    solids.altered = true;
    bind_matter(marked(solids, {b}), matter);
    return i;
}

void remove_element(Index element, const Matter& matter) {
    Solids& solids = matter.solids;
    const auto b = static_cast<std::size_t>(solids.elements.owner[element]);
    if (solids.bodies[b].size() == 1)
        throw InputError("the last particle of body {} is not removed: a body keeps at least one", solids.bodies[b].id);
    const Index particle = solids.particle_of[element];
    solids.element_of[static_cast<std::size_t>(solids.elements.id[element])] = kNone;
    std::vector<Index> rows(solids.elements.size());
    std::iota(rows.begin(), rows.end(), Index(0));
    rows.erase(rows.begin() + element);
    select_matter(rows, matter);
    std::vector<Index> particles(matter.particles.size());
    std::iota(particles.begin(), particles.end(), Index(0));
    particles.erase(particles.begin() + particle);
    keep_table_rows(matter.particles, particles);
    locate_particles(matter.particles, solids);
    bind_matter(marked(solids, {b}), matter);
}

std::optional<TrimNode> trim_of_fragment(const std::optional<TrimNode>& source, const SolidBody& body) {
    if (body.cuts.empty()) return source;
    TrimNode tree{TrimNode::Op::all, 0, {source ? *source : TrimNode{}}};
    for (const std::int32_t sheet : body.cuts) tree.parts.push_back({TrimNode::Op::sheet, sheet, {}});
    return tree;
}

}  // namespace thixo
