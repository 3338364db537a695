#include <algorithm>
#include <numeric>
#include <optional>
#include <tuple>

#include "pipeline/base/parallel.h"
#include "sim/solid/contact.h"
#include "sim/solid/element_fit.h"
#include "sim/solid/solids.h"
#include "sim/solid/stable_step.h"
#include "sim/solid/wall_contact.h"

namespace thixo {
namespace {

constexpr Real kSteepest = 3;             // most that the distance may change over a way in the world
constexpr Real kStirred = Real(0.05);     // least displacement by which elements of one body can meet, in widths
constexpr Real kInside = Real(0.1);       // how far ahead the face is looked for that a sample meets, in widths
constexpr Real kSameFace = Real(0.99);    // cosine between its normals at that depth and at half of it
constexpr Real kFacing = Real(0.2);       // least cosine between the surfaces' normals, one of them turned round
constexpr Real kGripDamping = Real(0.5);  // of critical, of friction's spring
constexpr Real kMemory = 8;               // of friction, in times that the contact's spring takes for a radian

std::size_t at(std::int32_t body) { return static_cast<std::size_t>(body); }

/// A body as the broad phase sees it.
struct Extent {
    Box3 box;            // of its elements
    Vec3 mean{0, 0, 0};  // velocity [m/s]
    Real spread = 0;     // largest speed against that [m/s]
    Real shift = 0;      // largest displacement [m]
    Real width = 0;      // of an element [m]
};

Extent extent_of(const SolidBody& body, const BodyPose& pose, const Elements& e, std::vector<Vec3>& place) {
    Extent out;
    out.width = std::cbrt(e.volume[body.typical]);
    out.box.lower.setConstant(std::numeric_limits<Real>::max());
    out.box.upper = -out.box.lower;
    Vec3d sum(0, 0, 0);
    double mass = 0;
    for (Index i = body.begin; i < body.end; ++i) {
        place[i] = pose.turn * (xyz(e.rest[i]) + xyz(e.displacement[i])) + pose.place;
        out.box.lower = out.box.lower.cwiseMin(place[i]);
        out.box.upper = out.box.upper.cwiseMax(place[i]);
        out.shift = std::max(out.shift, xyz(e.displacement[i]).squaredNorm());
        sum += static_cast<double>(e.mass[i]) * xyz(e.velocity[i]).cast<double>();
        mass += static_cast<double>(e.mass[i]);
    }
    const Vec3 mean = (sum / mass).cast<Real>();
    for (Index i = body.begin; i < body.end; ++i)
        out.spread = std::max(out.spread, (xyz(e.velocity[i]) - mean).squaredNorm());
    out.mean = pose.turn * mean;
    out.spread = std::sqrt(out.spread);
    out.shift = std::sqrt(out.shift);
    return out;
}

Real gap_of(const Box3& a, const Box3& b) { return (a.lower - b.upper).cwiseMax(b.lower - a.upper).maxCoeff(); }
bool holds(const Box3& box, Real by, const Vec3& x) {
    return ((x - box.lower).array() > -by).all() && ((box.upper - x).array() > -by).all();
}

/// What tells a node from all others, from one time to the next: its sample and partner, or its two elements.
using NodeKey = std::tuple<Index, std::int32_t, Index, Index>;

struct Found {
    Index sample = kNone, first = kNone, second = kNone;
    std::int32_t owner = 0, partner = 0;
    NodeKey key() const { return {sample, partner, first, second}; }
    Vec3 normal{0, 0, 0};
    Real gap = 0;
    Real area = 0;
    Real steepness = 1;  // of the distance at rest over a way in the world
    bool slides = true;
    std::vector<Index> element;  // the owner's, then from `middle` on the partner's
    std::vector<Real> weight;
    std::size_t middle = 0;
};

/// What finding nodes reads.
struct View {
    const Solids& solids;
    const std::vector<BodyPose>& poses;
    const std::vector<Extent>& extents;
    Real reach(std::int32_t body) const {  // how far the body's surface may lie from its elements' box
        const double stretch = std::sqrt(std::max(1.0, solids.stretch2));
        return extents[at(body)].width * static_cast<Real>(stretch);
    }
    Vec3 place_of(Index sample) const {
        const ContactSamples& s = solids.contacts.samples;
        Vec3 m = s.rest[sample];
        for (std::size_t k = s.weights.begin[sample]; k < s.weights.begin[sample + 1]; ++k)
            m += s.weights.weight[k] * xyz(solids.elements.displacement[s.weights.element[k]]);
        const BodyPose& pose = poses[at(s.owner[sample])];
        return pose.turn * m + pose.place;
    }
};

/// The outward normal of the surface at a sample, J^-T n of the element that it hangs on most; not unit.
Vec3 normal_of(const View& view, Index sample) {
    const ContactSamples& s = view.solids.contacts.samples;
    std::size_t host = s.weights.begin[sample];
    for (std::size_t k = host; k < s.weights.begin[sample + 1]; ++k)
        if (s.weights.weight[k] > s.weights.weight[host]) host = k;
    const Mat3 j = Mat3::Identity() + gradient_of(view.solids.elements, s.weights.element[host]);
    const Vec3& n = s.normal[sample];
    const Vec3 turned =
        j.col(1).cross(j.col(2)) * n.x() + j.col(2).cross(j.col(0)) * n.y() + j.col(0).cross(j.col(1)) * n.z();
    return view.poses[at(s.owner[sample])].turn * turned;
}

/// The node of a sample at x and a body, where its surface is nearer than the margin or passed.
std::optional<Found> meet(const View& view, Index sample, const Vec3& x, std::int32_t partner, ElementFit& fit) {
    const Contacts& c = view.solids.contacts;
    const Elements& e = view.solids.elements;
    const SolidBody& body = view.solids.bodies[at(partner)];
    const Real width = view.extents[at(partner)].width, margin = kContactMargin * width;
    if (!near_matter(view.solids, body, c.grid[at(partner)], x)) return std::nullopt;
    fit_elements(body, e, c.place, c.grid[at(partner)], view.poses[at(partner)].turn, e.support[body.typical], x, fit);
    const Vec3 m = fit.material + c.origin[at(partner)];
    const Shape& shape = c.shape[at(partner)];
    const Real d = shape.distance(m);
    if (!(d < 2 * margin)) return std::nullopt;
    // Of the partner's faces the one is met that lies before the sample's own: about an edge the distance alone knows
    // no face, and a plane aslant, or of the side that slides past, would be in the way of what slides. Where even that
    // face is not clear, an edge meets the sample's own face, whose plane it is then.
    const Vec3 own = normal_of(view, sample), inwards = fit.slope * own;
    const Vec3 ahead = kInside * width * inwards.normalized();
    const Vec3 face = shape.gradient(m + ahead, width / 64), before = shape.gradient(m + ahead / 2, width / 64);
    const bool clear = face.dot(before) > kSameFace;
    const Vec3 slope =
        clear ? Vec3(fit.slope.transpose() * face) : Vec3(-own.normalized() * inwards.norm() / own.norm());
    const Real steep = slope.norm();
    if (!(steep > Real(1e-3))) return std::nullopt;
    // A gap is of first order: where matter is pressed flat or drawn out more than this, that says nothing.
    const Real steepness = std::clamp(steep, 1 / kSteepest, kSteepest);
    if (!(d < margin * steepness)) return std::nullopt;
    // Surfaces meet face to face. Beyond the middle of a thin body the way out on its far side is no way back.
    if (slope.dot(own) > -kFacing * steep * own.norm()) return std::nullopt;
    const ContactSamples& s = c.samples;
    Found out;
    out.sample = sample;
    out.owner = s.owner[sample];
    out.partner = partner;
    out.gap = d / steepness;
    out.steepness = steepness;
    out.normal = slope / steep;
    out.area = s.area[sample] / 2;
    const auto first = static_cast<std::ptrdiff_t>(s.weights.begin[sample]),
               last = static_cast<std::ptrdiff_t>(s.weights.begin[sample + 1]);
    out.element.assign(s.weights.element.begin() + first, s.weights.element.begin() + last);
    out.weight.assign(s.weights.weight.begin() + first, s.weights.weight.begin() + last);
    out.middle = out.element.size();
    out.element.insert(out.element.end(), fit.element.begin(), fit.element.end());
    for (const Real w : fit.weight) out.weight.push_back(-w);
    return out;
}

/// Samples of one body that meet another one, ascending.
void find_between(const View& view, std::int32_t owner, std::int32_t partner, std::vector<Found>& found) {
    const ContactSamples& s = view.solids.contacts.samples;
    const Elements& e = view.solids.elements;
    const Box3& box = view.extents[at(partner)].box;
    const Real reach = view.reach(partner), wide = reach + 2 * e.support[view.solids.bodies[at(owner)].typical];
    const Index first = s.first[at(owner)];
    const std::size_t count = s.first[at(owner) + 1] - first;
    std::vector<Vec3> place(count);
    std::vector<std::uint8_t> near(count);
    parallel_for(count, [&](std::size_t k) {
        const Index sample = first + static_cast<Index>(k);
        // Most lie with a particle that is far away.
        near[k] = holds(box, wide, view.solids.contacts.place[s.weights.element[s.weights.begin[sample]]]);
        if (!near[k]) return;
        place[k] = view.place_of(sample);
        near[k] = holds(box, reach, place[k]);
    });
    std::vector<Index> candidates;
    for (std::size_t k = 0; k < count; ++k)
        if (near[k]) candidates.push_back(static_cast<Index>(k));
    std::vector<std::optional<Found>> met(candidates.size());
    parallel_chunks(
        candidates.size(),
        [&](std::size_t begin, std::size_t end, std::size_t) {
            ElementFit fit;
            for (std::size_t k = begin; k < end; ++k)
                met[k] = meet(view, first + candidates[k], place[candidates[k]], partner, fit);
        },
        32);
    for (auto& m : met)
        if (m) found.push_back(std::move(*m));
}

/// How much of an element meets others as a solid: its surface, or where matter melts off, all that is left of it.
Real solid_share(const View& view, Index i, Real width) {
    const Phases& phases = view.solids.phases;
    if (!phases.any) return view.solids.elements.depth[i] > width ? Real(0) : Real(1);
    return phases.bond[i] == Bond::rest ? 1 - phases.melt[i] : Real(0);
}

bool neighbours(const Elements& e, Index i, Index j) {
    for (std::size_t k = e.begin[i]; k < e.begin[i + 1]; ++k)
        if (e.neighbour[k] == j) return true;
    return false;
}

/// Elements of two bodies, or of one (5.9), that have come near and are no neighbours in a rest shape.
void find_elements(const View& view, std::int32_t owner, std::int32_t partner, std::vector<Found>& found) {
    const Contacts& c = view.solids.contacts;
    const Elements& e = view.solids.elements;
    const SolidBody &body = view.solids.bodies[at(owner)], &other = view.solids.bodies[at(partner)];
    const Real width = (view.extents[at(owner)].width + view.extents[at(partner)].width) / 2;
    const std::size_t count = body.end - body.begin;
    std::vector<std::vector<Index>> near(count);
    parallel_for(count, [&](std::size_t k) {
        const Index i = body.begin + static_cast<Index>(k);
        if (!(solid_share(view, i, width) > 0)) return;
        c.grid[at(partner)].for_each_neighbour(c.place[i], (1 + kContactMargin) * width, [&](Index number, Real) {
            const Index j = other.begin + number;
            if (owner == partner && (j <= i || neighbours(e, i, j))) return;
            if (solid_share(view, j, width) > 0) near[k].push_back(j);
        });
    });
    for (std::size_t k = 0; k < count; ++k)
        for (const Index j : near[k]) {
            const Index i = body.begin + static_cast<Index>(k);
            const Vec3 between = c.place[i] - c.place[j];
            const Real distance = between.norm();
            if (!(distance > 0)) continue;
            Found f;
            f.owner = owner;
            f.partner = partner;
            f.normal = between / distance;
            f.gap = distance - width;
            f.area = square(width) * std::min(solid_share(view, i, width), solid_share(view, j, width));
            f.first = i;
            f.second = j;
            // Matter that melts or has frozen anew meets without friction.
            f.slides = owner == partner && !view.solids.phases.any;
            f.element = {i, j};
            f.weight = {1, -1};
            f.middle = 1;
            found.push_back(std::move(f));
        }
}

void make_grid(std::int32_t number, Solids& solids) {
    Contacts& c = solids.contacts;
    if (c.gridded[at(number)]) return;
    const SolidBody& body = solids.bodies[at(number)];
    c.grid[at(number)].build(std::span(c.place).subspan(body.begin, body.end - body.begin),
                             solids.elements.support[body.typical]);
    c.gridded[at(number)] = 1;
}

struct PairLaw {
    Real pressure, damping, grip, friction;  // [Pa/m], per area [kg/(m^2 s)], the same, [1]
    Real memory;                             // [s]
};
PairLaw pair_law(const Solids& solids, std::int32_t a, std::int32_t b) {
    const auto layer = [&](std::int32_t body) {  // 1/k and 1/(mass per area)
        const Index i = solids.bodies[at(body)].typical;
        const Elements& e = solids.elements;
        return std::pair(1 / contact_pressure(solids.laws[at(body)], e.volume[i]),
                         square(std::cbrt(e.volume[i])) / e.mass[i]);
    };
    const auto [soft_a, light_a] = layer(a);
    const auto [soft_b, light_b] = layer(b);
    const StressLaw &la = solids.laws[at(a)], &lb = solids.laws[at(b)];
    PairLaw law{};
    law.pressure = 1 / (soft_a + soft_b);
    const Real rate = std::sqrt(law.pressure * (light_a + light_b));
    const Real critical = 2 * law.pressure / rate;
    law.damping = critical * (la.contact_damping + lb.contact_damping) / 2;
    law.grip = critical * kGripDamping;
    law.friction = std::sqrt(la.friction * lb.friction);
    law.memory = kMemory / rate;
    return law;
}

template <class T>
void append(std::vector<T>& list, const std::vector<T>& more) {
    list.insert(list.end(), more.begin(), more.end());
}

/// Nodes in place of the old ones, which tell what they remember; `explained` [m] by pair: what is in its speed.
void take_over(const View& view, std::vector<Found>& found, const std::vector<Real>& explained, Solids& solids) {
    const ContactNodes old = std::move(solids.contacts.nodes);
    ContactNodes& n = solids.contacts.nodes = {};
    std::vector<Index> order(found.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return found[a].key() < found[b].key(); });
    std::size_t before = 0;
    const auto key = [&](std::size_t k) { return NodeKey{old.sample[k], old.partner[k], old.first[k], old.second[k]}; };
    const std::size_t bodies = solids.bodies.size();
    for (const Index k : order) {
        const Found& f = found[k];
        while (before < old.size() && key(before) < f.key()) ++before;
        const bool known = before < old.size() && key(before) == f.key();
        const Real excess = known ? old.excess[before] : Real(0), depth = known ? old.depth[before] : Real(0);
        const Real width = view.extents[at(f.partner)].width;
        const Real most = depth + kUnexplained * width + explained[at(f.owner) * bodies + at(f.partner)];
        n.sample.push_back(f.sample);
        n.partner.push_back(f.partner);
        n.first.push_back(f.first);
        n.second.push_back(f.second);
        n.excess.push_back(f.sample == kNone ? Real(0) : std::min(excess, f.gap + most));
        n.depth.push_back(depth);
        n.slip.push_back(known ? old.slip[before] : Vec3(0, 0, 0));
        n.press.push_back(known ? old.press[before] : Real(0));
        n.pressed.push_back(known ? old.pressed[before] : Real(0));
        n.owner.push_back(f.owner);
        n.normal.push_back(f.normal);
        n.gap.push_back(f.gap);
        const PairLaw law = pair_law(solids, f.owner, f.partner);
        n.stiffness.push_back(law.pressure * f.area * square(f.steepness));
        n.damping.push_back(law.damping * f.area * f.steepness);
        n.drag.push_back(f.slides ? law.grip * f.area * f.steepness : Real(0));
        n.friction.push_back(f.slides ? law.friction : Real(0));
        n.memory.push_back(law.memory);
        n.area.push_back(f.area);
        n.middle.push_back(n.weights.element.size() + f.middle);
        append(n.weights.element, f.element);
        append(n.weights.weight, f.weight);
        n.weights.begin.push_back(n.weights.element.size());
    }
    n.start.resize(n.size());
    n.force.resize(n.size());
    parallel_for(n.size(), [&](std::size_t k) {
        const auto sum = [&](std::size_t begin, std::size_t end) {
            Vec3 u(0, 0, 0);
            for (std::size_t l = begin; l < end; ++l)
                u += n.weights.weight[l] * xyz(solids.elements.displacement[n.weights.element[l]]);
            return u;
        };
        n.start[k] = view.poses[at(n.owner[k])].turn * sum(n.weights.begin[k], n.middle[k]) +
                     view.poses[at(n.partner[k])].turn * sum(n.middle[k], n.weights.begin[k + 1]);
    });
    n.last = n.start;
}

/// How bodies meet others: by their shapes, those that still have them; what has softened, melted in part or frozen
/// in another shape, element by element, and what is liquid, not at all: it meets others by its pressure.
enum class Meets : std::uint8_t { not_at_all, by_elements, by_shape };
std::vector<Meets> ways_to_meet(const Solids& solids) {
    const Phases& phases = solids.phases;
    std::vector<Meets> ways(solids.bodies.size(), Meets::not_at_all);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        if (body.begin == body.end) continue;
        ways[b] = Meets::by_shape;
        if (!phases.any) continue;
        bool whole = b < solids.contacts.shape.size() && !phases.refrozen[b], any = false;
        for (Index i = body.begin; i < body.end; ++i) {
            const bool bound = phases.bond[i] == Bond::rest;
            whole = whole && bound && !(phases.melt[i] > 0);
            any = any || (bound && phases.melt[i] < 1);
        }
        ways[b] = whole ? Meets::by_shape : any ? Meets::by_elements : Meets::not_at_all;
    }
    return ways;
}

/// No shorter than this are the times between finds, however fast a body that has gone wrong is [s].
double shortest_time(const Solids& solids, const std::vector<Extent>& extents) {
    double shortest = 1e30;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const Index i = solids.bodies[b].typical;
        if (!(extents[b].width > 0)) continue;
        const Real sound =
            std::sqrt(solids.laws[b].wave_modulus() * solids.elements.volume[i] / solids.elements.mass[i]);
        shortest = std::min(shortest, static_cast<double>(extents[b].width / sound));
    }
    return shortest / 100;
}

}  // namespace

bool near_matter(const Solids& solids, const SolidBody& body, const PointGrid& grid, const Vec3& x) {
    constexpr double kReach = 1.4;  // from any place of a surface to the nearest element, and the margin, in widths
    const double width = std::cbrt(static_cast<double>(solids.elements.volume[body.typical]));
    const auto reach = static_cast<Real>(kReach * width * std::sqrt(std::max(1.0, solids.stretch2)));
    bool near = reach > grid.cell();
    if (!near) grid.for_each_neighbour(x, reach, [&](Index, Real) { near = true; });
    return near;
}

void find_contacts(double time, double dt, Solids& solids) {
    Contacts& c = solids.contacts;
    const std::size_t count = solids.bodies.size();
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    c.place.resize(solids.elements.size());
    const std::vector<Meets> meets = ways_to_meet(solids);
    std::vector<Extent> extents(count);
    parallel_for(
        count,
        [&](std::size_t b) {
            if (meets[b] != Meets::not_at_all)
                extents[b] = extent_of(solids.bodies[b], poses[b], solids.elements, c.place);
        },
        1);
    const View view{solids, poses, extents};
    c.grid.resize(count);
    c.gridded.assign(count, 0);
    const double shortest = shortest_time(solids, extents);
    double holds_for = dt;
    const auto last_for = [&](Real way, Real speed) {
        holds_for = std::min(holds_for, std::max(shortest, static_cast<double>(way) / static_cast<double>(speed)));
    };
    std::vector<Found> found;
    std::vector<Real> explained(count * count, 0);
    for (std::int32_t a = 0; a < static_cast<std::int32_t>(count); ++a) {
        if (meets[at(a)] == Meets::not_at_all) continue;
        const Extent& ea = extents[at(a)];
        if (ea.shift > kStirred * ea.width) {
            make_grid(a, solids);
            find_elements(view, a, a, found);
            last_for(kContactMargin * ea.width, 2 * ea.spread);
        }
        for (std::int32_t b = a + 1; b < static_cast<std::int32_t>(count); ++b) {
            if (meets[at(b)] == Meets::not_at_all) continue;
            const Extent& eb = extents[at(b)];
            const Real speed = (ea.mean - eb.mean).norm() + ea.spread + eb.spread;
            const Real gap = gap_of(ea.box, eb.box) - view.reach(a) - view.reach(b);
            const Real margin = kContactMargin * std::min(ea.width, eb.width);
            if (gap > margin) {
                last_for(gap, speed);
                continue;
            }
            last_for(margin, speed);
            explained[at(a) * count + at(b)] = explained[at(b) * count + at(a)] =
                speed * static_cast<Real>(solids.last_dt);
            make_grid(a, solids);
            make_grid(b, solids);
            if (meets[at(a)] == Meets::by_elements || meets[at(b)] == Meets::by_elements) {
                find_elements(view, a, b, found);
                continue;
            }
            find_between(view, a, b, found);
            find_between(view, b, a, found);
        }
    }
    c.next = time + holds_for;
    take_over(view, found, explained, solids);
    list_by_element(solids);
}

}  // namespace thixo
