#include "sim/fracture/shown.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/kernels.h"
#include "sim/bonds/gradients.h"
#include "sim/fracture/tension.h"
#include "sim/solid/elasticity.h"

namespace thixo {
namespace {

/// sqrt(3/2 s : s) with the deviator s.
Real von_mises_of(const Symmetric& a) {
    const Real mean = (a.xx + a.yy + a.zz) / 3;
    const Real normal = square(a.xx - mean) + square(a.yy - mean) + square(a.zz - mean);
    return std::sqrt(Real(1.5) * (normal + 2 * (square(a.xy) + square(a.yz) + square(a.zx))));
}

/// A node in the world, and the piece that carries it.
struct ShownNode {
    Vec3 place;
    std::int32_t owner;
};
ShownNode shown_node(const Solids& solids, const CrackedMatter& matter, const std::vector<BodyPose>& poses,
                     const std::vector<Mat3>& gradients, const Vec3& m) {
    const Elements& e = solids.elements;
    std::vector<std::pair<Real, Index>> near;
    matter.grid().nearest(m, 1, std::numeric_limits<Real>::max(), near);
    const Index nearest = matter.elements()[near.front().second];
    const std::int32_t owner = e.owner[nearest];
    const auto moved = [&](Index j) -> Vec3 {
        return m + xyz(e.displacement[j]) + gradients[j] * (m - xyz(e.rest[j]));
    };
    const Poly6 w(matter.breaking().support);
    Real weight = 0;
    Vec3 sum(0, 0, 0);
    matter.grid().for_each_neighbour(m, matter.breaking().support, [&](Index k, Real r2) {
        const Index j = matter.elements()[k];
        if (e.owner[j] != owner) return;
        weight += w.value(r2);
        sum += w.value(r2) * moved(j);
    });
    const BodyPose& pose = poses[static_cast<std::size_t>(owner)];
    return {pose.turn * (weight > 0 ? Vec3(sum / weight) : moved(nearest)) + pose.place, owner};
}

/// The lines of a front, one for each run of nodes in one piece.
void show(const CrackFront& front, const std::vector<ShownNode>& nodes, std::vector<ShownFront>& shown) {
    const bool whole = std::ranges::all_of(nodes, [&](const ShownNode& n) { return n.owner == nodes[0].owner; });
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        if (k == 0 || nodes[k].owner != nodes[k - 1].owner)
            shown.push_back({.closed = whole && front.closed != 0, .nodes = {}});
        shown.back().nodes.push_back(nodes[k].place);
    }
}

}  // namespace

ShownStress shown_stress(const Solids& solids) {
    const Elements& e = solids.elements;
    ShownStress shown;
    shown.load.assign(e.size(), 0);
    shown.von_mises.assign(e.size(), 0);
    if (solids.laws.empty()) return shown;  // before the first step nothing is deformed
    std::vector<Mat3> gradients;
    find_gradients(e, gradients);
    parallel_for(e.size(), [&](std::size_t i) {
        if (e.phase_of(i) != Phase::solid) return;
        const Symmetric stress = stress_of_shape(solids.laws[static_cast<std::size_t>(e.owner[i])], e, i, gradients[i]);
        shown.von_mises[i] = static_cast<float>(von_mises_of(stress));
        if (e.strength[i] < kUnbreakable)
            shown.load[i] = static_cast<float>(std::max(largest_tension(stress).value, Real(0)) / e.strength[i]);
    });
    return shown;
}

std::vector<ShownFront> shown_fronts(const Solids& solids) {
    std::vector<ShownFront> shown;
    if (solids.cracks.fronts.empty()) return shown;
    std::vector<Mat3> gradients;
    find_gradients(solids.elements, gradients);
    const std::vector<BodyPose> poses = poses_of(solids.bodies);
    for (const Breaking& breaking : solids.breaking) {
        const CrackedMatter matter(solids, breaking);
        if (matter.elements().empty()) continue;
        for (const CrackFront& front : solids.cracks.fronts) {
            if (solids.cracks.cracks[static_cast<std::size_t>(front.crack)].frame != breaking.frame) continue;
            std::vector<ShownNode> nodes;
            for (const CrackNode& node : front.nodes)
                nodes.push_back(shown_node(solids, matter, poses, gradients, node.tip()));
            show(front, nodes, shown);
        }
    }
    return shown;
}

}  // namespace thixo
