#include <algorithm>
#include <cmath>
#include <numeric>

#include "pipeline/base/parallel.h"
#include "sim/contact/answer.h"
#include "sim/contact/contact.h"
#include "sim/contact/narrow.h"
#include "sim/contact/stiffness.h"

namespace thixo {
namespace {

constexpr Real kStirred = Real(0.05);     // least displacement by which elements of one body can meet, in widths
constexpr Real kSlipDamping = Real(0.5);  // of critical, of friction's spring
constexpr Real kMemory = 8;               // of friction, in times of one radian of the contact's spring

void make_grid(std::int32_t number, Solids& solids) {
    std::uint8_t& gridded = solids.contacts.gridded[at(number)];
    if (!gridded) build_grid(number, solids);
    gridded = 1;
}

struct PairLaw {
    Real pressure;       // [Pa/m]
    Real damping, drag;  // per area, along the normal and across [kg/(m^2 s)]
    Real friction;       // [1]
    Real memory;         // [s]
};
/// A wall is infinitely stiff and heavy.
PairLaw pair_law(const Solids& solids, std::int32_t a, std::int32_t b) {
    const auto layer = [&](std::int32_t body) {  // 1/k and 1/(mass per area)
        const Index i = solids.bodies[at(body)].typical;
        const Elements& e = solids.elements;
        return std::pair(1 / contact_pressure(solids.laws[at(body)], e.volume[i]),
                         square(std::cbrt(e.volume[i])) / e.mass[i]);
    };
    const auto [soft_a, light_a] = layer(a);
    const auto [soft_b, light_b] = is_wall(b) ? std::pair(Real(0), Real(0)) : layer(b);
    const StressLaw &la = solids.laws[at(a)], &lb = solids.laws[is_wall(b) ? at(a) : at(b)];
    PairLaw law{};
    law.pressure = 1 / (soft_a + soft_b);
    const Real rate = std::sqrt(law.pressure * (light_a + light_b));
    const Real critical = 2 * law.pressure / rate;
    law.damping = critical * (la.contact_damping + lb.contact_damping) / 2;
    law.drag = critical * kSlipDamping;
    law.friction = std::sqrt(la.friction * lb.friction);
    law.memory = kMemory / rate;
    return law;
}

template <class T>
void append(std::vector<T>& list, const std::vector<T>& more) {
    list.insert(list.end(), more.begin(), more.end());
}

/// Replaces the old nodes by those found. Nodes found again keep the state of the old ones.
void take_over(const View& view, const NodeFrames& frames, std::vector<Found>& found, Solids& solids) {
    const ContactNodes old = std::move(solids.contacts.nodes);
    ContactNodes& n = solids.contacts.nodes = {};
    std::vector<Index> order(found.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return found[a].key() < found[b].key(); });
    std::size_t before = 0;
    const auto key = [&](std::size_t k) { return NodeKey{old.sample[k], old.partner[k], old.first[k], old.second[k]}; };
    for (const Index k : order) {
        const Found& f = found[k];
        while (before < old.size() && key(before) < f.key()) ++before;
        const bool known = before < old.size() && key(before) == f.key();
        const Real excess = known ? old.excess[before] : Real(0), depth = known ? old.depth[before] : Real(0);
        const Real width = view.extents[at(is_wall(f.partner) ? f.owner : f.partner)].width;
        const Real most = depth + kUnexplained * width + f.explained;
        n.sample.push_back(f.sample);
        n.partner.push_back(f.partner);
        n.first.push_back(f.first);
        n.second.push_back(f.second);
        n.excess.push_back(view.solids.softening.any && f.sample == kNone ? Real(0) : std::min(excess, f.gap + most));
        n.depth.push_back(depth);
        n.slip.push_back(known ? old.slip[before] : Vec3(0, 0, 0));
        n.normal_force.push_back(known ? old.normal_force[before] : Real(0));
        n.duration.push_back(known ? old.duration[before] : Real(0));
        n.owner.push_back(f.owner);
        n.normal.push_back(f.normal);
        n.gap.push_back(f.gap);
        n.place.push_back(f.place);
        n.anchor.push_back(f.anchor);
        const PairLaw law = pair_law(solids, f.owner, f.partner);
        n.stiffness.push_back(law.pressure * f.area * square(f.steepness));
        n.damping.push_back(law.damping * f.area * f.steepness);
        n.drag.push_back(f.slides ? law.drag * f.area * f.steepness : Real(0));
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
    parallel_for(n.size(),
                 [&](std::size_t k) { n.start[k] = displacement_of_node(n, solids.elements.displacement, frames, k); });
    n.last = n.start;
}

/// How a body meets others. A body with a shape of its own meets them by this shape. One that has softened, melted in
/// part or frozen in another shape meets them element by element. Liquid meets nothing here: it acts by its pressure.
enum class Meets : std::uint8_t { not_at_all, by_elements, by_shape };
std::vector<Meets> ways_to_meet(const Solids& solids) {
    const Elements& e = solids.elements;
    std::vector<Meets> ways(solids.bodies.size(), Meets::not_at_all);
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        if (body.empty()) continue;
        ways[b] = body.shape ? Meets::by_shape : Meets::by_elements;
        if (!solids.softening.any) continue;
        bool unmolten = body.shape.has_value(), any = false;
        for (const Index i : body.elements) {
            const Real solidity = e.solidity(i);
            unmolten = unmolten && solidity == 1;
            any = any || solidity > 0;
        }
        ways[b] = unmolten ? Meets::by_shape : any ? Meets::by_elements : Meets::not_at_all;
    }
    return ways;
}

/// The least time between two searches, even where a diverging body is very fast [s].
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

/// The largest speed of a body's matter relative to a wall [m/s].
Real speed_beside(const Wall& wall, const Extent& body) {
    const Vec3 middle = (body.box.lower + body.box.upper) / 2;
    const Real radius = (body.box.upper - body.box.lower).norm() / 2;
    return (body.mean - wall.velocity_at(middle)).norm() + body.spread + wall.spin.norm() * radius;
}

/// Pairs of bodies that may touch within a step of dt [s], or come so near that nodes must be found again before its
/// end. Each box grows by the most that the surface lies outside of it, and by half a margin. It also grows by its
/// travel in the step relative to the mean motion of all.
std::vector<std::pair<std::int32_t, std::int32_t>> pairs_within_reach(const View& view, const std::vector<Meets>& meets,
                                                                      double dt) {
    constexpr Real kRounding = Real(1.001);
    const std::size_t count = meets.size();
    Vec3d sum(0, 0, 0);
    double bodies = 0;
    for (std::size_t b = 0; b < count; ++b) {
        if (meets[b] == Meets::not_at_all) continue;
        sum += view.extents[b].mean.cast<double>();
        ++bodies;
    }
    const Vec3 mean = (sum / std::max(1.0, bodies)).cast<Real>();
    std::vector<Box3> boxes(count, Box3{Vec3::Constant(1), Vec3::Constant(-1)});
    for (std::size_t b = 0; b < count; ++b) {
        if (meets[b] == Meets::not_at_all) continue;
        const Extent& e = view.extents[b];
        const Real travel = static_cast<Real>(dt) * ((e.mean - mean).norm() + e.spread);
        const Real by = kRounding * (view.reach(static_cast<std::int32_t>(b)) + kContactMargin * e.width / 2 + travel);
        boxes[b] = {e.box.lower.array() - by, e.box.upper.array() + by};
    }
    return touching_pairs(boxes);
}

}  // namespace

bool near_matter(const Solids& solids, const SolidBody& body, const PointGrid& grid, const Vec3& x) {
    constexpr double kReach = 1.4;  // from any place of a surface to the nearest element, plus the margin, in widths
    const double width = std::cbrt(static_cast<double>(solids.elements.volume[body.typical]));
    const auto reach = static_cast<Real>(kReach * width * std::sqrt(std::max(1.0, solids.stretch2)));
    bool near = reach > grid.cell();
    if (!near) grid.for_each_neighbour(x, reach, [&](Index, Real) { near = true; });
    return near;
}

void find_contacts(const Walls& walls, double time, double dt, Solids& solids) {
    Contacts& c = solids.contacts;
    const std::size_t count = solids.bodies.size();
    const NodeFrames frames(solids, walls);
    const std::vector<BodyPose>& poses = frames.poses;
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
    const auto last_for = [&](Real distance, Real speed) {
        holds_for = std::min(holds_for, std::max(shortest, static_cast<double>(distance) / static_cast<double>(speed)));
    };
    std::vector<Found> found;
    for (std::int32_t a = 0; a < static_cast<std::int32_t>(count); ++a) {
        const Extent& ea = extents[at(a)];
        if (meets[at(a)] == Meets::not_at_all || !(ea.shift > kStirred * ea.width)) continue;
        make_grid(a, solids);
        find_elements(view, a, a, 2 * ea.spread * static_cast<Real>(solids.last_dt), found);
        last_for(kContactMargin * ea.width, 2 * ea.spread);
    }
    for (const auto& [a, b] : pairs_within_reach(view, meets, dt)) {
        const Extent &ea = extents[at(a)], &eb = extents[at(b)];
        const Real speed = (ea.mean - eb.mean).norm() + ea.spread + eb.spread;
        const Real gap = gap_of(ea.box, eb.box) - view.reach(a) - view.reach(b);
        const Real margin = kContactMargin * std::min(ea.width, eb.width);
        if (gap > margin) {
            last_for(gap, speed);
            continue;
        }
        last_for(margin, speed);
        make_grid(a, solids);
        make_grid(b, solids);
        const Real explained = speed * static_cast<Real>(solids.last_dt);
        if (meets[at(a)] == Meets::by_elements || meets[at(b)] == Meets::by_elements) {
            find_elements(view, a, b, explained, found);
            continue;
        }
        find_samples(view, a, b, explained, found);
        find_samples(view, b, a, explained, found);
    }
    c.by_samples.assign(count, 0);
    for (std::int32_t a = 0; a < static_cast<std::int32_t>(count); ++a) {
        c.by_samples[at(a)] = meets[at(a)] == Meets::by_shape && c.samples.first[at(a)] < c.samples.first[at(a) + 1];
        if (!c.by_samples[at(a)]) continue;
        for (std::size_t w = 0; w < walls.list.size(); ++w) {
            const Real speed = speed_beside(walls.list[w], extents[at(a)]);
            last_for(find_samples_at_wall(view, a, walls, w, speed * static_cast<Real>(solids.last_dt), found), speed);
        }
    }
    c.next = time + holds_for;
    take_over(view, frames, found, solids);
    list_by_element(solids);
}

}  // namespace thixo
