#include "sim/fracture/crack_events.h"

#include <algorithm>

#include "sim/fracture/crack_parts.h"
#include "sim/fracture/fronts.h"

namespace thixo {
namespace {

constexpr Real kOver = Real(0.15);  // rows: how far beyond another sheet an end stands
constexpr Real kSnap = Real(1.5);   // rows: between two sheets nearer than this there is hardly an element

/// The normal of the sheet at node i of a front; zero where it has none.
Vec3 sheet_normal(const CrackFront& front, std::size_t i) {
    return front.nodes[i].heading.cross(between_neighbours(front, i)).normalized();
}

/// Whether a triangle is of the sheet just behind a node: it does not count as another sheet.
bool own_row(const Cracks& cracks, std::int32_t crack, Index triangle, Real row) {
    const CrackTriangles& t = cracks.triangles;
    return t.crack[triangle] == crack && t.behind[triangle] < Real(2.5) * row;
}

/// Whether a node runs towards a triangle.
bool is_ahead(const CrackNode& node, Index triangle, const Cracks& cracks) {
    return (middle_of(cracks, triangle) - node.place).dot(node.heading) > 0;
}

/// The place `on`, or a little beyond it as seen from x.
Vec3 beyond(const Vec3& x, const Vec3& on, Real by) {
    const Vec3 way = on - x;
    const Real length = way.norm();
    return length > by ? Vec3(on + by / length * way) : on;
}

/// Ends a node that crosses a sheet of an earlier row, or has come near one.
void meet_sheets(const CrackedMatter& matter, const CrackFront& front, CrackNode& node, Vec3& to,
                 const Cracks& cracks) {
    const Breaking& breaking = matter.breaking();
    const Vec3 way = to - node.place;
    const Real length = way.norm();
    if (!(length > 0)) return;
    const auto other = [&](Index k) { return !own_row(cracks, front.crack, k, breaking.row); };
    const auto ahead = [&](Index k) { return other(k) && is_ahead(node, k, cracks); };
    Real nearest = 2 * length;
    matter.sheets().for_each_crossing(node.place, to + kOver * breaking.row / length * way,
                                      [&](Index k, const Vec3& at) {
                                          if (other(k)) nearest = std::min(nearest, (at - node.place).norm());
                                      });
    if (nearest < 2 * length) {
        to = node.place + (nearest + kOver * breaking.row) / length * way;
        node.state = NodeState::met;
    } else if (const auto near = matter.sheets().nearest(node.place, kSnap * breaking.row, ahead)) {
        to = beyond(node.place, near->place, kOver * breaking.row);
        node.state = NodeState::met;
    }
}

/// Ends at other sheets stay there when the front beside them goes on.
void stay_met(const CrackedMatter& matter, const CrackFront& front, const CrackNode& node, Vec3& to,
              const Cracks& cracks) {
    const Breaking& breaking = matter.breaking();
    if (to == node.place) return;
    const auto other = [&](Index k) { return !own_row(cracks, front.crack, k, breaking.row); };
    if (const auto near = matter.sheets().nearest(to, 3 * breaking.row, other))
        to = beyond(to, near->place, kOver * breaking.row);
}

struct Rank {
    std::size_t w, node;  // of `which`
};

/// Distance of two nodes along one front, in nodes.
std::size_t apart(const CrackFront& front, std::size_t i, std::size_t k) {
    const std::size_t d = i > k ? i - k : k - i;
    return front.closed ? std::min(d, front.nodes.size() - d) : d;
}

void meet_fronts(const Breaking& breaking, const std::vector<std::size_t>& which, std::vector<std::vector<Vec3>>& to,
                 Cracks& cracks) {
    constexpr Real kMeet = Real(1.5);  // rows: each may go one before they are compared again
    std::vector<Rank> ranks;
    for (std::size_t w = 0; w < which.size(); ++w)
        for (std::size_t i = 0; i < to[w].size(); ++i) ranks.push_back({w, i});
    const auto node = [&](const Rank& r) -> CrackNode& { return cracks.fronts[which[r.w]].nodes[r.node]; };
    for (std::size_t a = 0; a < ranks.size(); ++a) {
        CrackNode& p = node(ranks[a]);
        if (p.state == NodeState::met) continue;
        for (std::size_t b = a + 1; b < ranks.size(); ++b) {
            CrackNode& q = node(ranks[b]);
            if (q.state == NodeState::met) continue;
            Vec3 &x = to[ranks[a].w][ranks[a].node], &y = to[ranks[b].w][ranks[b].node];
            if ((x - y).squaredNorm() > square(kMeet * breaking.row) || p.heading.dot(q.heading) >= 0) continue;
            if (ranks[a].w == ranks[b].w && apart(cracks.fronts[which[ranks[a].w]], ranks[a].node, ranks[b].node) < 3)
                continue;
            if ((y - x).dot(p.heading - q.heading) <= 0) continue;  // they run apart
            const Vec3 mean = (x + y) / 2;
            x = y = mean;
            p.state = q.state = NodeState::met;
            break;
        }
    }
}

/// The pieces of a front between nodes that have ended.
std::vector<CrackFront> pieces_of(CrackFront front) {
    const auto inside = [](const CrackNode& node) { return node.state == NodeState::inside; };
    if (std::ranges::none_of(front.nodes, inside)) return {};
    if (std::ranges::all_of(front.nodes, inside)) return {std::move(front)};
    if (front.closed) {
        // Opened at a node that has ended, which is both ends.
        const auto ended = std::ranges::find_if_not(front.nodes, inside);
        std::ranges::rotate(front.nodes, ended);
        front.nodes.push_back(front.nodes.front());
        front.closed = 0;
    }
    std::vector<CrackFront> pieces;
    const std::size_t n = front.nodes.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (!inside(front.nodes[i])) continue;
        const std::size_t begin = i > 0 ? i - 1 : i;
        while (i + 1 < n && inside(front.nodes[i + 1])) ++i;
        const std::size_t end = std::min(i + 2, n);
        const auto at = [&](std::size_t k) { return front.nodes.begin() + static_cast<std::ptrdiff_t>(k); };
        pieces.push_back({.crack = front.crack, .closed = 0, .nodes = {at(begin), at(end)}});
    }
    return pieces;
}

/// Whether a front has shrunk to about a row's length: a closed one has met itself, an open one is in a corner.
bool has_shrunk(const CrackFront& front, const Breaking& breaking) {
    const std::size_t n = front.nodes.size();
    Real length = 0, opening = 0;
    for (std::size_t i = 0; i + (front.closed ? 0 : 1) < n; ++i) {
        const CrackNode &a = front.nodes[i], &b = front.nodes[(i + 1) % n];
        length += (b.place - a.place).norm();
        opening += (b.heading - a.heading).dot(b.place - a.place);  // > 0: the nodes run apart
    }
    const bool grows = opening > 0 && front.closed;
    return n < 3 || (!grows && length <= (front.closed ? 3 : 2) * breaking.row);
}

/// Where a node of a front in a corner would leave the body or meet another sheet, straight on.
Vec3 run_out(const CrackedMatter& matter, const CrackFront& front, const CrackNode& node, const Cracks& cracks) {
    const Breaking& breaking = matter.breaking();
    Vec3 to = node.place;
    for (int k = 0; k < 8 && breaking.distance(to) < kEndLevel * breaking.row; ++k)
        to += breaking.row / 2 * node.heading;
    Real nearest = (to - node.place).norm();
    matter.sheets().for_each_crossing(node.place, to, [&](Index k, const Vec3& at) {
        if (own_row(cracks, front.crack, k, breaking.row)) return;
        nearest = std::min(nearest, (at - node.place).norm() + kOver * breaking.row);
    });
    return node.place + nearest * node.heading;
}

/// Fills what a front that has shrunk leaves: the hole within a closed one, the corner before an open one.
void close_gap(const CrackedMatter& matter, const CrackFront& front, Cracks& cracks) {
    const auto& nodes = front.nodes;
    const std::size_t n = nodes.size();
    if (front.closed) {
        for (std::size_t i = 1; i + 1 < n; ++i)
            add_triangle(front.crack, {nodes[0].vertex, nodes[i].vertex, nodes[i + 1].vertex},
                         nodes[i].place - nodes[0].place, nodes[i].heading, cracks);
        return;
    }
    std::vector<Index> ahead;
    for (const CrackNode& node : nodes)
        ahead.push_back(node.state == NodeState::inside ? add_vertex(run_out(matter, front, node, cracks), cracks)
                                                        : node.vertex);
    for (std::size_t i = 0; i + 1 < n; ++i) {
        const Vec3 along = nodes[i + 1].place - nodes[i].place, heading = nodes[i].heading + nodes[i + 1].heading;
        add_triangle(front.crack, {nodes[i].vertex, nodes[i + 1].vertex, ahead[i + 1]}, along, heading, cracks);
        add_triangle(front.crack, {nodes[i].vertex, ahead[i + 1], ahead[i]}, along, heading, cracks);
    }
}

CrackNode between(const CrackFront& front, std::size_t i, std::size_t k, Cracks& cracks) {
    const std::size_t n = front.nodes.size();
    const CrackNode &a = front.nodes[i], &b = front.nodes[k];
    const bool has_before = i > 0 || front.closed, has_after = k + 1 < n || front.closed;
    const Vec3 before = has_before ? front.nodes[(i + n - 1) % n].place : a.place;  // the end itself at an end
    const Vec3 after = has_after ? front.nodes[(k + 1) % n].place : b.place;
    CrackNode node;
    // The cubic spline of Catmull & Rom 1974 in its middle.
    node.place = (9 * (a.place + b.place) - before - after) / 16;
    node.advance = (a.advance + b.advance) / 2;
    node.heading = (a.heading + b.heading).normalized();
    node.vertex = add_vertex(node.place, cracks);
    return node;
}

void put_in_nodes(CrackFront& front, const Breaking& breaking, Cracks& cracks) {
    constexpr Real kFar = Real(1.5);
    for (std::size_t i = 0; i + (front.closed ? 0 : 1) < front.nodes.size(); ++i) {
        const std::size_t k = (i + 1) % front.nodes.size();
        if ((front.nodes[k].place - front.nodes[i].place).norm() < kFar * breaking.row) continue;
        if ((front.nodes[i].heading + front.nodes[k].heading).norm() < Real(0.1)) continue;
        const CrackNode node = between(front, i, k, cracks);
        add_triangle(front.crack, {front.nodes[i].vertex, front.nodes[k].vertex, node.vertex},
                     front.nodes[k].place - front.nodes[i].place, node.heading, cracks);
        front.nodes.insert(front.nodes.begin() + static_cast<std::ptrdiff_t>(i + 1), node);
        ++i;
    }
}

void take_out_nodes(CrackFront& front, const Breaking& breaking, Cracks& cracks) {
    constexpr Real kNear = Real(0.4);
    for (std::size_t i = 0; i < front.nodes.size() && front.nodes.size() > 3;) {
        const std::size_t n = front.nodes.size();
        const bool end = !front.closed && (i == 0 || i + 1 == n);
        const CrackNode &node = front.nodes[i], &before = front.nodes[(i + n - 1) % n],
                        &after = front.nodes[(i + 1) % n];
        if (end || node.state != NodeState::inside || (node.place - before.place).norm() > kNear * breaking.row) {
            ++i;
            continue;
        }
        add_triangle(front.crack, {before.vertex, node.vertex, after.vertex}, after.place - before.place, node.heading,
                     cracks);
        front.nodes.erase(front.nodes.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

}  // namespace

Vec3 at_end_level(const Breaking& breaking, const Vec3& normal, const Vec3& m) {
    Vec3 place = m;
    for (int k = 0; k < 3; ++k) {  // Newton's method: distances bend at edges
        const Vec3 outward = breaking.outward(place);
        Vec3 way = outward;
        if (normal.allFinite()) way -= normal.dot(outward) * normal;
        if (way.norm() < Real(0.3)) way = outward;  // the crack runs along the surface
        way.normalize();
        place += (kEndLevel * breaking.row - breaking.distance(place)) / way.dot(outward) * way;
    }
    // At a corner the plane may not reach the level near by.
    const Real off = breaking.distance(place) - kEndLevel * breaking.row;
    return std::abs(off) < kEndLevel / 2 * breaking.row ? place : Vec3(place - off * breaking.outward(place));
}

void meet(const CrackedMatter& matter, const std::vector<std::size_t>& which, std::vector<std::vector<Vec3>>& to,
          Cracks& cracks) {
    const Breaking& breaking = matter.breaking();
    meet_fronts(breaking, which, to, cracks);
    for (std::size_t w = 0; w < which.size(); ++w) {
        CrackFront& front = cracks.fronts[which[w]];
        for (std::size_t i = 0; i < front.nodes.size(); ++i) {
            CrackNode& node = front.nodes[i];
            if (node.state == NodeState::met)
                stay_met(matter, front, node, to[w][i], cracks);
            else
                meet_sheets(matter, front, node, to[w][i], cracks);
            const bool outside = breaking.distance(to[w][i]) > 0;
            if (node.state == NodeState::inside && outside) node.state = NodeState::surface;
            if (to[w][i] != node.place && (node.state == NodeState::surface || outside))
                to[w][i] = at_end_level(breaking, sheet_normal(front, i), to[w][i]);
        }
    }
}

void split_fronts(const CrackedMatter& matter, Cracks& cracks) {
    const Breaking& breaking = matter.breaking();
    std::vector<CrackFront> remaining;
    for (CrackFront& front : cracks.fronts) {
        if (!runs(front, breaking, cracks)) {
            remaining.push_back(std::move(front));
            continue;
        }
        for (CrackFront& piece : pieces_of(std::move(front))) {
            if (has_shrunk(piece, breaking))
                close_gap(matter, piece, cracks);
            else
                remaining.push_back(std::move(piece));
        }
    }
    cracks.fronts = std::move(remaining);
}

void space_nodes(const Breaking& breaking, Cracks& cracks) {
    for (CrackFront& front : cracks.fronts) {
        if (!runs(front, breaking, cracks)) continue;
        take_out_nodes(front, breaking, cracks);
        put_in_nodes(front, breaking, cracks);
    }
}

}  // namespace thixo
