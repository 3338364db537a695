#include "sim/fracture/fragments.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "pipeline/base/error.h"
#include "pipeline/geometry/shapes.h"
#include "pipeline/geometry/surface_sampling.h"
#include "sim/bonds/gradients.h"
#include "sim/bonds/members.h"
#include "sim/contact/contact.h"
#include "sim/fracture/rigid_fragments.h"
#include "sim/fracture/sheets.h"

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

/// Moves elements, their particles and surfels from one body to another, as far as they go.
void move_matter(std::size_t from, std::size_t to, const std::function<bool(Index)>& element_goes,
                 const std::function<bool(Index)>& surfel_goes, const Matter& matter) {
    Solids& solids = matter.solids;
    Elements& e = solids.elements;
    SolidBody &old = solids.bodies[from], &now = solids.bodies[to];
    std::vector<Index> stays;
    for (const Index i : old.elements) {
        if (!element_goes(i)) {
            stays.push_back(i);
            continue;
        }
        now.elements.push_back(i);
        e.owner[i] = static_cast<std::int32_t>(to);
        matter.particles.body[solids.particle_of[i]] = now.id;
    }
    old.elements = std::move(stays);
    EmbeddedSurface& s = matter.embedded;
    for (Index i = 0; i < s.size(); ++i)
        if (s.owner[i] == static_cast<std::int32_t>(from) && surfel_goes(i)) s.owner[i] = static_cast<std::int32_t>(to);
}
/// The same by place in the material frame.
void move_matter(std::size_t from, std::size_t to, const std::function<bool(const Vec3&)>& goes, const Matter& matter) {
    move_matter(
        from, to, [&](Index i) { return goes(xyz(matter.solids.elements.rest[i])); },
        [&](Index i) { return goes(matter.embedded.rest.position[i]); }, matter);
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

/// Appends a face to a body's surfels, as a sheet of its own that it lies behind.
void append_face(const SurfelCloud& face, std::size_t b, std::int32_t sheet, const Matter& matter) {
    append_family(face, std::vector<std::int32_t>(face.size(), sheet), b, matter);
    matter.solids.bodies[b].cuts.push_back(sheet);
}

/// The pieces of a body: a number for each of its elements, in their order. The largest piece is 0; of equals, that of
/// the first element.
std::vector<std::size_t> pieces_of(const SolidBody& body, const Elements& e, std::size_t& count) {
    constexpr std::size_t kNew = static_cast<std::size_t>(-1);
    std::vector<std::size_t> piece(e.size(), kNew), size;
    for (const Index start : body.elements) {
        if (piece[start] != kNew) continue;
        std::vector<Index> reached{start};
        piece[start] = size.size();
        for (std::size_t k = 0; k < reached.size(); ++k)
            for (std::size_t l = e.bonds.begin[reached[k]]; l < e.bonds.begin[reached[k] + 1]; ++l)
                if (const Index j = e.bonds.neighbour[l]; e.bonds.weight[l] > 0 && piece[j] == kNew) {
                    piece[j] = size.size();
                    reached.push_back(j);
                }
        size.push_back(reached.size());
    }
    const auto largest = static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
    std::vector<std::size_t> number;
    for (const Index i : body.elements)
        number.push_back(piece[i] == largest ? 0 : piece[i] < largest ? piece[i] + 1 : piece[i]);
    count = size.size();
    return number;
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
        const std::int32_t partner = old.partner[k];
        if (bodies[owner] || (!is_wall(partner) && bodies[static_cast<std::size_t>(partner)])) continue;
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

namespace {

void bind_to(const std::vector<std::uint8_t>& bodies, const std::vector<Index>* surfels, const Matter& matter) {
    Solids& solids = matter.solids;
    std::vector<std::uint8_t> drawn(bodies.size());  // those whose surfels are bound to them
    for (std::size_t b = 0; b < bodies.size(); ++b)
        drawn[b] = bodies[b] && !solids.bodies[b].empty() && solids.bodies[b].skin == Skin::embedded;
    EmbeddedSurface& s = matter.embedded;
    const CrackSight sight(solids);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b)
        if (bodies[b] && !solids.bodies[b].empty())
            choose_examples(solids.elements, matter.smoothing, solids.bodies[b]);
    if (s.size() > 0 && surfels) {
        s.grid.resize(solids.bodies.size());
        s.trim.resize(solids.bodies.size());
        for (std::size_t b = 0; b < solids.bodies.size(); ++b)
            if (drawn[b]) s.grid[b] = {};
        bind_some_surfels(solids, *surfels, s, element_sight(sight));
    } else if (s.size() > 0) {
        bind_surfels(solids, drawn, s, element_sight(sight));
    }
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        SolidBody& body = solids.bodies[b];
        if (!bodies[b] || body.empty()) continue;
        if (!body.scene_shape && !body.refrozen) body.shape = shape_of_surfels(s, body, static_cast<std::int32_t>(b));
    }
    // A lone body meets nothing and has no samples. At its first split all bodies without samples get some.
    std::vector<std::uint8_t> sampled = bodies;
    const std::vector<Index>& first = solids.contacts.samples.first;
    for (std::size_t b = 0; b < bodies.size(); ++b)
        if (!sampled[b] && first[b] == first[b + 1]) sampled[b] = 1;
    const ContactSamples before = sample_bodies(sampled, matter.seed, solids);
    forget_nodes(sampled, before, solids.contacts);
}

/// The surfels of these bodies that elements of another of them might move, or that have no weights yet, ascending.
/// After a split these alone are bound anew, and all those of bodies that are `changed` throughout.
std::vector<Index> surfels_at_splits(const std::vector<std::uint8_t>& bodies, const std::vector<std::uint8_t>& changed,
                                     const Matter& matter) {
    const Solids& solids = matter.solids;
    const EmbeddedSurface& s = matter.embedded;
    const auto marked = [&](std::size_t i) { return bodies[static_cast<std::size_t>(s.owner[i])] != 0; };
    const auto reach = [&](std::size_t i) {
        return s.support[i] + std::max(s.rest.axis1[i].norm(), s.rest.axis2[i].norm());
    };
    std::map<std::int32_t, std::vector<Index>> elements;  // by the frame that they share
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        if (!bodies[b]) continue;
        auto& own = elements[solids.bodies[b].frame];
        own.insert(own.end(), solids.bodies[b].elements.begin(), solids.bodies[b].elements.end());
    }
    std::vector<std::uint8_t> found(s.size(), 0);
    for (const auto& [frame, members] : elements) {
        Real widest = 0;
        for (std::size_t i = 0; i < s.size(); ++i)
            if (marked(i)) widest = std::max(widest, reach(i));
        if (!(widest > 0)) break;  // these bodies have no surfels
        std::vector<Vec3> place;
        for (const Index i : members) place.push_back(xyz(solids.elements.rest[i]));
        PointGrid grid;
        grid.build(place, widest);
        parallel_for(s.size(), [&](std::size_t i) {
            if (!marked(i) || solids.bodies[static_cast<std::size_t>(s.owner[i])].frame != frame) return;
            found[i] = s.begin[i] == s.begin[i + 1] || changed[static_cast<std::size_t>(s.owner[i])] != 0;
            grid.for_each_neighbour(s.rest.position[i], reach(i), [&](Index k, Real) {
                if (solids.elements.owner[members[k]] != s.owner[i]) found[i] = 1;
            });
        });
    }
    std::vector<Index> rows;
    for (Index i = 0; i < s.size(); ++i)
        if (found[i]) rows.push_back(i);
    return rows;
}

/// Ends bonds at a split. None of these bodies has the scene's shape any more.
void part(const std::vector<std::uint8_t>& bodies, const Matter& matter) {
    Solids& solids = matter.solids;
    part_bonds(solids.elements);
    for (std::size_t b = 0; b < bodies.size(); ++b)
        if (bodies[b]) solids.bodies[b].scene_shape = false;
    const std::vector<std::uint8_t> rigid = make_rigid(bodies, matter);
    // Elements of several sizes: the width of a body's surfels' weights follows from all of its elements.
    const bool alike = !matter.particles.has.spacing && solids.elements.breaks;
    const std::vector<Index> some = alike ? surfels_at_splits(bodies, rigid, matter) : std::vector<Index>();
    bind_to(bodies, alike ? &some : nullptr, matter);
}

}  // namespace

void bind_matter(const std::vector<std::uint8_t>& bodies, const Matter& matter) { bind_to(bodies, nullptr, matter); }

std::size_t split_body(std::size_t b, const std::function<bool(const Vec3&)>& goes, const Matter& matter) {
    refuse_empty_side(b, goes, matter.solids);
    const std::size_t to = append_fragment(b, matter.solids);
    matter.embedded.trim.emplace_back();
    matter.embedded.grid.emplace_back();
    move_matter(b, to, goes, matter);
    part(marked(matter.solids, {b, to}), matter);
    return to;
}

bool has_come_apart(const SolidBody& body, const Elements& elements) {
    std::size_t count = 0;
    pieces_of(body, elements, count);
    return count > 1;
}

std::size_t part_fragments(const std::vector<std::uint8_t>& bodies, const std::function<Index(Index)>& nearest,
                           const Matter& matter) {
    Solids& solids = matter.solids;
    std::vector<std::uint8_t> marks = bodies;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        if (!bodies[b] || solids.bodies[b].empty()) continue;
        std::size_t count = 0;
        const std::vector<Index> elements = solids.bodies[b].elements;
        const std::vector<std::size_t> number = pieces_of(solids.bodies[b], solids.elements, count);
        if (count < 2) {
            marks[b] = 0;
            continue;
        }
        std::vector<std::size_t> piece(solids.elements.size(), 0);
        for (std::size_t k = 0; k < elements.size(); ++k) piece[elements[k]] = number[k];
        std::vector<std::size_t> of_surfel(matter.embedded.size(), 0);
        // Elements that move a surfel are seen by it. Where they are of several pieces it goes with the nearest.
        const EmbeddedSurface& s = matter.embedded;
        parallel_for(of_surfel.size(), [&](std::size_t i) {
            if (s.owner[i] != static_cast<std::int32_t>(b)) return;
            bool one = s.begin[i] < s.begin[i + 1];
            for (std::size_t k = s.begin[i]; one && k < s.begin[i + 1]; ++k)
                one = piece[s.weight[k].element] == piece[s.weight[s.begin[i]].element];
            of_surfel[i] = piece[one ? s.weight[s.begin[i]].element : nearest(static_cast<Index>(i))];
        });
        for (std::size_t k = 1; k < count; ++k) {
            const std::size_t to = append_fragment(b, solids);
            matter.embedded.trim.emplace_back();
            matter.embedded.grid.emplace_back();
            marks.push_back(1);
            move_matter(
                b, to, [&](Index i) { return piece[i] == k; }, [&](Index i) { return of_surfel[i] == k; }, matter);
        }
    }
    const std::size_t created = marks.size() - bodies.size();
    if (created > 0) part(marks, matter);
    return created;
}

std::size_t append_family(const SurfelCloud& cloud, const std::vector<std::int32_t>& sheets, std::size_t b,
                          const Matter& matter) {
    constexpr std::int64_t kFirst = std::int64_t(1) << 50, kFamily = std::int64_t(1) << 36;
    EmbeddedSurface& s = matter.embedded;
    const std::size_t first = s.size();
    const auto own = std::ranges::find(s.owner, static_cast<std::int32_t>(b));
    const Real temperature =
        own == s.owner.end() ? Real(0) : s.temperature[static_cast<std::size_t>(own - s.owner.begin())];
    append_surfels(cloud, matter.solids.bodies[b], static_cast<std::int32_t>(b), s);
    for (std::size_t i = first; i < s.size(); ++i) {
        s.sheet[i] = sheets[i - first];
        s.temperature[i] = temperature;
    }
    const std::int64_t base = kFirst + kFamily * s.families_made++;
    s.families.push_back(
        {.first = static_cast<Index>(first), .base = base, .shift = static_cast<std::int64_t>(cloud.size()) - base});
    matter.solids.altered = true;
    return first;
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
    part(marked(matter.solids, {b, to}), matter);
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
    e.volume[i] = e.quadrature[i] = given.volume;
    e.support[i] = given.support;
    e.depth[i] = given.depth;
    e.displacement[i] = quad(xyz(e.displacement[host]) + h * way);
    e.velocity[i] = e.velocity[host];
    e.acceleration[i] = e.acceleration[host];
    e.plastic[i] = e.plastic[host];
    if (e.hardens) e.hardened[i] = e.hardened[host];
    if (e.breaks) {
        e.strength[i] = e.strength[host];
        e.own_strength[i] = e.own_strength[host];
    }
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

namespace {

/// The part of a tree over these sheets alone; none where it has none of them. What it is the difference from stays.
std::optional<TrimNode> over_sheets(const TrimNode& node, const std::vector<std::int32_t>& sheets) {
    if (node.op == TrimNode::Op::sheet)
        return std::ranges::binary_search(sheets, node.sheet) ? std::optional(node) : std::nullopt;
    TrimNode pruned{node.op, 0, {}, node.reach};
    for (std::size_t k = 0; k < node.parts.size(); ++k) {
        if (auto part = over_sheets(node.parts[k], sheets))
            pruned.parts.push_back(std::move(*part));
        else if (node.op == TrimNode::Op::except && k == 0)
            pruned.parts.push_back(node.parts[k]);
    }
    return pruned.parts.empty() ? std::nullopt : std::optional(std::move(pruned));
}

}  // namespace

std::optional<TrimNode> trim_of_fragment(const std::optional<TrimNode>& source, const SolidBody& body,
                                         const std::vector<std::int32_t>& sheets, float reach) {
    const auto first_crack = std::ranges::lower_bound(sheets, kFirstCrackSheet);
    if (body.cuts.empty() && first_crack == sheets.end()) return source;
    TrimNode tree{TrimNode::Op::all, 0, {}, 0};
    const std::optional<TrimNode> own = over_sheets(source.value_or(TrimNode{}), sheets);
    if (own) tree.parts.push_back(*own);
    for (const std::int32_t sheet : body.cuts) tree.parts.push_back(sheet_node(sheet));
    for (auto at = first_crack; at != sheets.end(); ++at) {
        const std::int32_t sheet = *at;
        const bool both = std::next(at) != sheets.end() && *std::next(at) / 2 == sheet / 2;
        TrimNode crack = sheet_node(sheet);
        if (both) crack = {TrimNode::Op::any, 0, {sheet_node(sheet), sheet_node(sheet + 1)}, 0};
        crack.reach = reach;
        tree.parts.push_back(std::move(crack));
        if (both) ++at;
    }
    return tree;
}

std::vector<std::vector<std::int32_t>> sheets_of(const EmbeddedSurface& s, std::size_t bodies) {
    std::vector<std::vector<std::int32_t>> sheets(bodies);
    for (std::size_t i = 0; i < s.size(); ++i) {
        auto& own = sheets[static_cast<std::size_t>(s.owner[i])];
        if (own.empty() || own.back() != s.sheet[i]) own.push_back(s.sheet[i]);
    }
    for (auto& own : sheets) {
        std::ranges::sort(own);
        own.erase(std::ranges::unique(own).begin(), own.end());
    }
    return sheets;
}

}  // namespace thixo
