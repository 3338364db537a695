#include "sim/fracture/painted.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "sim/fracture/crack_events.h"
#include "sim/fracture/fronts.h"

namespace thixo {
namespace {

/// The line just outside of the surface, where ends stand.
std::vector<Vec3> rim_of(const std::vector<Vec3>& line, bool ring, const Breaking& breaking) {
    for (std::size_t i = 0; i < line.size(); ++i)
        if (const Real off = std::abs(breaking.distance(line[i])); !(off <= breaking.width))
            throw InputError("point {} is {:.3g} m off the surface of the body, more than the {:.3g} m of a particle",
                             i, off, breaking.width);
    std::vector<Vec3> rim = even_steps(line, breaking.row, ring);
    for (Vec3& x : rim) {
        if (const Real off = std::abs(breaking.distance(x)); !(off <= breaking.support))
            throw InputError("the line is {:.3g} m off the surface of the body between its points; give it more", off);
        x = at_end_level(breaking, Vec3::Constant(std::numeric_limits<Real>::quiet_NaN()), x);
    }
    return rim;
}

/// A front at the first row below the rim, and the triangles between the two.
CrackFront cut_first_row(const std::vector<Vec3>& rim, bool ring, Real depth, std::int32_t crack,
                         const Breaking& breaking, Cracks& cracks) {
    CrackFront front{.crack = crack, .closed = ring ? 1 : 0, .nodes = {}};
    const std::size_t n = rim.size();
    std::vector<Index> top;
    for (const Vec3& x : rim) top.push_back(add_vertex(x, cracks));
    for (std::size_t k = 0; k < n; ++k) {
        if (!ring && (k == 0 || k + 1 == n)) {
            const Vec3 out = k == 0 ? Vec3(rim[0] - rim[1]) : Vec3(rim[k] - rim[k - 1]);
            front.nodes.push_back(
                {.place = rim[k], .heading = out.normalized(), .vertex = top[k], .state = NodeState::surface});
            continue;
        }
        const Vec3 inward = -breaking.outward(rim[k]);
        const Vec3 place = rim[k] + (breaking.distance(rim[k]) + depth) * inward;
        front.nodes.push_back({.place = place, .heading = inward, .vertex = add_vertex(place, cracks)});
    }
    for (std::size_t k = 0; k + (ring ? 0 : 1) < n; ++k) {
        const std::size_t next = (k + 1) % n;
        const Vec3 along = rim[next] - rim[k], ahead = -breaking.outward(rim[k]) - breaking.outward(rim[next]);
        const Index a = front.nodes[k].vertex, b = front.nodes[next].vertex;
        add_triangle(crack, {top[k], top[next], b}, along, ahead, cracks);
        add_triangle(crack, {top[k], b, a}, along, ahead, cracks);
    }
    return front;
}

}  // namespace

std::vector<Vec3> even_steps(const std::vector<Vec3>& line, Real row, bool ring) {
    Real length = 0;
    for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
    const int steps = std::max(ring ? 3 : 2, static_cast<int>(std::ceil(length / row)));
    std::vector<Vec3> out;
    std::size_t i = 1;
    Real before = 0;  // length up to point i - 1
    for (int k = 0; k <= steps - (ring ? 1 : 0); ++k) {
        const Real at = length * static_cast<Real>(k) / static_cast<Real>(steps);
        while (i + 1 < line.size() && at > before + (line[i] - line[i - 1]).norm()) {
            before += (line[i] - line[i - 1]).norm();
            ++i;
        }
        const Real part = std::min((at - before) / (line[i] - line[i - 1]).norm(), Real(1));
        out.push_back(line[i - 1] + part * (line[i] - line[i - 1]));
    }
    return out;
}

void paint_crack(const std::vector<Vec3>& line, const PaintedCut& cut, const Breaking& breaking, Solids& solids) {
    const bool ring = line.size() > 3 && line.front() == line.back();
    const std::vector<Vec3> rim = rim_of(line, ring, breaking);
    Cracks& cracks = solids.cracks;
    const auto crack = static_cast<std::int32_t>(cracks.cracks.size());
    cracks.cracks.push_back({.source = breaking.source,
                             .frame = breaking.frame,
                             .sheet = kFirstCrackSheet + 2 * crack,
                             .strength = cut.strength});
    Real deep = std::min(breaking.row, cut.depth);
    cracks.fronts.push_back(cut_first_row(rim, ring, deep, crack, breaking, cracks));
    // The last part of a row is left to the front's first step.
    while (cut.depth - deep > Real(0.05) * breaking.row) {
        const Real way = std::min(breaking.row, cut.depth - deep);
        deep += way;
        for (CrackFront& front : cracks.fronts) {
            if (front.crack != crack) continue;
            for (CrackNode& node : front.nodes)
                if (node.state == NodeState::inside) node.advance = way * node.heading;
        }
        lay_rows(CrackedMatter(solids, breaking), cracks);
    }
}

}  // namespace thixo
