#include "sim/fracture/fronts.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "sim/fracture/crack_events.h"
#include "sim/fracture/crack_parts.h"

namespace thixo {
namespace {

constexpr std::uint64_t kOffset = 0x637261636b;  // use of random numbers

struct Motion {
    Vec3 direction{0, 0, 0};
    Real speed = 0;  // [m/s]
};

/// The motion that the stress ahead of a node asks for, where the strength is a share of the material's.
Motion motion_of(const FrontStep& step, const CrackFront& front, std::size_t i, Real share) {
    const CrackNode& node = front.nodes[i];
    const Breaking& breaking = step.matter.breaking();
    Motion motion{node.heading, 0};
    if (node.state == NodeState::met) return motion;
    Vec3 along = between_neighbours(front, i).normalized(), probe = node.tip();
    if (node.state == NodeState::surface) {
        along = -breaking.outward(probe);
        probe += (breaking.distance(probe) + breaking.row / 2) * along;
    }
    probe += breaking.row / 2 * node.heading;
    CrackedMatter::Local local = step.matter.at(probe, step.stress);
    local.strength *= share;
    const Tension tension = largest_tension(local.stress);
    if (!(local.strength > 0) || !(tension.value > 0) || tension.value < breaking.arrest * local.strength) {
        bool gapes = false;
        step.gaping.for_each_neighbour(node.place, 2 * breaking.row, [&](Index, Real) { gapes = true; });
        if (gapes) motion.speed = breaking.speed;
        return motion;
    }
    Vec3 d = tension.axis.cross(along);
    const Real size = d.norm();
    if (size < Real(0.2)) return motion;  // it is pulled along its front, not open
    d /= d.dot(node.heading) < 0 ? -size : size;
    return {d, breaking.speed * std::min(tension.value / local.strength, Real(2))};
}

/// Means of neighbours, (1, 2, 1)/4, over the nodes inside: a front bends no sharper than its nodes stand.
std::vector<Motion> smoothed(const CrackFront& front, const std::vector<Motion>& raw) {
    std::vector<Motion> out = raw;
    const std::size_t n = raw.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (front.nodes[i].state != NodeState::inside) continue;
        Vec3 direction = 2 * raw[i].direction;
        Real speed = 2 * raw[i].speed, weight = 2;
        const auto add = [&](std::size_t k) {
            if (front.nodes[k].state == NodeState::met) return;
            direction += raw[k].direction;
            speed += raw[k].speed;
            weight += 1;
        };
        if (i > 0 || front.closed) add((i + n - 1) % n);
        if (i + 1 < n || front.closed) add((i + 1) % n);
        out[i].speed = speed / weight;
        if (direction.norm() > Real(0.1)) out[i].direction = direction.normalized();
    }
    return out;
}

void move_node(const FrontStep& step, const Motion& motion, CrackNode& node) {
    const Breaking& breaking = step.matter.breaking();
    const Real way = motion.speed * static_cast<Real>(step.dt);
    if (!(way > 0)) return;
    const Real kept = std::pow(breaking.history, std::min(way, breaking.row) / breaking.width);
    const Vec3 heading = kept * node.heading + (1 - kept) * motion.direction;
    if (heading.norm() > Real(0.1)) node.heading = heading.normalized();
    node.advance += way * node.heading;
    if (const Real gone = node.advance.norm(); gone > breaking.row) node.advance *= breaking.row / gone;
}

/// Ends at other cracks go with the node beside them.
void follow_neighbour(CrackFront& front) {
    const std::size_t n = front.nodes.size();
    if (n < 2 || front.closed) return;
    const auto follow = [&](CrackNode& end, const CrackNode& beside) {
        if (end.state != NodeState::met) return;
        end.advance = beside.advance;
        end.heading = beside.heading;
    };
    follow(front.nodes.front(), front.nodes[1]);
    follow(front.nodes.back(), front.nodes[n - 2]);
}

CrackFront new_front(std::int32_t crack, bool closed, const std::vector<std::pair<Vec3, NodeState>>& nodes,
                     const Vec3& middle, Cracks& cracks) {
    CrackFront front{.crack = crack, .closed = closed ? 1 : 0, .nodes = {}};
    for (const auto& [place, state] : nodes)
        front.nodes.push_back({.place = place,
                               .heading = (place - middle).normalized(),
                               .vertex = add_vertex(place, cracks),
                               .state = state});
    return front;
}

}  // namespace

Index add_vertex(const Vec3& place, Cracks& cracks) {
    cracks.vertex.push_back(place);
    return static_cast<Index>(cracks.vertex.size() - 1);
}

void add_triangle(std::int32_t crack, const std::array<Index, 3>& v, const Vec3& along, const Vec3& ahead,
                  Cracks& cracks) {
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) return;
    const Vec3 &a = cracks.vertex[v[0]], &b = cracks.vertex[v[1]], &c = cracks.vertex[v[2]];
    const bool folded = (b - a).cross(c - a).dot(along.cross(ahead)) <= 0;
    CrackTriangles& t = cracks.triangles;
    const Index row = append_row(t);
    t.a[row] = v[0], t.b[row] = v[1], t.c[row] = v[2];
    t.crack[row] = crack;
    t.drawn[row] = folded;
    t.bound[row] = -1;
}

std::size_t begin_crack(const Vec3& m, const Vec3& axis, const Breaking& breaking, Cracks& cracks) {
    const auto crack = static_cast<std::int32_t>(cracks.cracks.size());
    cracks.cracks.push_back(
        {.source = breaking.source, .frame = breaking.frame, .sheet = kFirstCrackSheet + 2 * crack});
    const Real row = breaking.row, depth = -breaking.distance(m);
    const Vec3 inward = -breaking.outward(m);
    Vec3 in = inward - inward.dot(axis) * axis;
    const bool at_surface = depth < breaking.width && in.norm() > Real(0.5);
    in = at_surface || in.norm() > Real(0.1) ? Vec3(in.normalized()) : Vec3(axis.unitOrthogonal());
    const Vec3 side = axis.cross(in);
    CrackFront front;
    if (at_surface) {
        // To the surface, within the plane of the crack.
        const Vec3 top = m - depth / std::max(in.dot(inward), Real(0.5)) * in;
        const auto end = [&](Real way) { return at_end_level(breaking, axis, top + way * side); };
        front = new_front(
            crack, false,
            {{end(row), NodeState::surface}, {top + row * in, NodeState::inside}, {end(-row), NodeState::surface}}, top,
            cracks);
        front.nodes[0].heading = side;
        front.nodes[2].heading = -side;
    } else {
        std::vector<std::pair<Vec3, NodeState>> nodes;
        for (int k = 0; k < 3; ++k) {
            const Real angle = static_cast<Real>(2 * kPi * k / 3);
            nodes.emplace_back(m + row / 2 * (std::cos(angle) * in + std::sin(angle) * side), NodeState::inside);
        }
        front = new_front(crack, true, nodes, m, cracks);
    }
    const Index v = front.nodes[0].vertex;
    add_triangle(crack, {v, v + 2, v + 1}, at_surface ? Vec3(-side) : side, in, cracks);
    cracks.fronts.push_back(std::move(front));
    return static_cast<std::size_t>(crack);
}

Real begin_cracks(const FrontStep& step, std::uint64_t seed, std::uint64_t number, const Elements& e, Cracks& cracks) {
    const CrackedMatter& matter = step.matter;
    const Breaking& breaking = matter.breaking();
    const auto load = [&](Index i) { return step.tension[i].value / e.strength[i]; };
    Real largest = 0;
    std::vector<Index> candidates;
    for (const Index i : matter.elements()) {
        largest = std::max(largest, load(i));
        if (load(i) > 1) candidates.push_back(i);
    }
    std::ranges::sort(candidates,
                      [&](Index a, Index b) { return std::pair(-load(a), e.id[a]) < std::pair(-load(b), e.id[b]); });
    std::vector<Vec3> begun;
    constexpr Real kNear = 1, kNearNew = 2;  // supports
    for (const Index i : candidates) {
        const Vec3 m = xyz(e.rest[i]);
        if (std::ranges::any_of(begun, [&](const Vec3& b) { return (b - m).norm() < kNearNew * breaking.support; }))
            continue;
        if (matter.sheets().nearest(m, kNear * breaking.support, [](Index) { return true; })) continue;
        const double u = 2 * random_unit(seed, static_cast<std::uint64_t>(e.id[i]), number, kOffset) - 1;
        const Real off = static_cast<Real>(u < 0 ? u * 0.3 - 0.1 : u * 0.3 + 0.1) * breaking.width;
        const Vec3& axis = step.tension[i].axis;
        begin_crack(m + off * axis, axis, breaking, cracks);
        begun.push_back(m);
    }
    return largest;
}

Real move_fronts(const FrontStep& step, Cracks& cracks) {
    const Breaking& breaking = step.matter.breaking();
    Real fastest = 0;
    for (CrackFront& front : cracks.fronts) {
        if (!runs(front, breaking, cracks)) continue;
        std::vector<Motion> raw(front.nodes.size());
        const Real share = cracks.cracks[static_cast<std::size_t>(front.crack)].strength;
        parallel_for(
            raw.size(), [&](std::size_t i) { raw[i] = motion_of(step, front, i, share); }, 8);
        const std::vector<Motion> motions = smoothed(front, raw);
        for (std::size_t i = 0; i < raw.size(); ++i) {
            move_node(step, motions[i], front.nodes[i]);
            fastest = std::max(fastest, motions[i].speed);
        }
        follow_neighbour(front);
    }
    return fastest;
}

bool row_is_due(const Breaking& breaking, const Cracks& cracks) {
    constexpr Real kDue = Real(0.7);
    return std::ranges::any_of(cracks.fronts, [&](const CrackFront& front) {
        return runs(front, breaking, cracks) && std::ranges::any_of(front.nodes, [&](const CrackNode& node) {
                   return node.advance.norm() > kDue * breaking.row;
               });
    });
}

void lay_rows(const CrackedMatter& matter, Cracks& cracks) {
    const Breaking& breaking = matter.breaking();
    constexpr Real kLeast = Real(0.05);  // of a row: nodes that have moved less stay
    std::vector<std::size_t> which;
    std::vector<std::vector<Vec3>> to;
    for (std::size_t f = 0; f < cracks.fronts.size(); ++f) {
        if (!runs(cracks.fronts[f], breaking, cracks)) continue;
        which.push_back(f);
        auto& places = to.emplace_back();
        for (const CrackNode& node : cracks.fronts[f].nodes)
            places.push_back(node.advance.norm() > kLeast * breaking.row ? node.tip() : node.place);
    }
    meet(matter, which, to, cracks);
    for (std::size_t w = 0; w < which.size(); ++w) {
        CrackFront& front = cracks.fronts[which[w]];
        const std::size_t n = front.nodes.size();
        const std::vector<CrackNode> old = front.nodes;
        for (std::size_t i = 0; i < n; ++i) {
            CrackNode& node = front.nodes[i];
            if (to[w][i] == node.place) continue;
            node.place = to[w][i];
            node.advance.setZero();
            node.vertex = add_vertex(node.place, cracks);
        }
        for (std::size_t i = 0; i + (front.closed ? 0 : 1) < n; ++i) {
            const std::size_t k = (i + 1) % n;
            const CrackNode &a = old[i], &b = old[k], &c = front.nodes[k], &d = front.nodes[i];
            const Vec3 along = b.place - a.place, ahead = a.heading + b.heading;
            add_triangle(front.crack, {a.vertex, b.vertex, c.vertex}, along, ahead, cracks);
            add_triangle(front.crack, {a.vertex, c.vertex, d.vertex}, along, ahead, cracks);
        }
    }
    split_fronts(matter, cracks);
    space_nodes(breaking, cracks);
}

}  // namespace thixo
