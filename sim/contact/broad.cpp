#include "sim/contact/broad.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace thixo {

Extent extent_of(const SolidBody& body, const BodyPose& pose, const Elements& e, std::vector<Vec3>& place) {
    Extent out;
    out.width = std::cbrt(e.volume[body.typical]);
    out.box.lower.setConstant(std::numeric_limits<Real>::max());
    out.box.upper = -out.box.lower;
    Vec3d sum(0, 0, 0);
    double mass = 0;
    for (const Index i : body.elements) {
        place[i] = pose.turn * (xyz(e.rest[i]) + xyz(e.displacement[i])) + pose.place;
        out.box.lower = out.box.lower.cwiseMin(place[i]);
        out.box.upper = out.box.upper.cwiseMax(place[i]);
        out.shift = std::max(out.shift, xyz(e.displacement[i]).squaredNorm());
        sum += static_cast<double>(e.mass[i]) * xyz(e.velocity[i]).cast<double>();
        mass += static_cast<double>(e.mass[i]);
    }
    const Vec3 mean = (sum / mass).cast<Real>();
    for (const Index i : body.elements) out.spread = std::max(out.spread, (xyz(e.velocity[i]) - mean).squaredNorm());
    out.mean = pose.turn * mean;
    out.spread = std::sqrt(out.spread);
    out.shift = std::sqrt(out.shift);
    return out;
}

void build_grid(std::int32_t body, Solids& solids) {
    const auto b = static_cast<std::size_t>(body);
    const SolidBody& of = solids.bodies[b];
    std::vector<Vec3> place;
    place.reserve(of.size());
    for (const Index i : of.elements) place.push_back(solids.contacts.place[i]);
    solids.contacts.grid[b].build(place, solids.elements.support[of.typical]);
}

std::vector<std::pair<std::int32_t, std::int32_t>> touching_pairs(const std::vector<Box3>& boxes) {
    std::vector<std::int32_t> order;
    Vec3d sum(0, 0, 0), squares(0, 0, 0);
    for (std::size_t k = 0; k < boxes.size(); ++k) {
        if (!(boxes[k].lower.array() <= boxes[k].upper.array()).all()) continue;
        order.push_back(static_cast<std::int32_t>(k));
        const Vec3d middle = (boxes[k].lower + boxes[k].upper).cast<double>() / 2;
        sum += middle;
        squares += middle.cwiseAbs2();
    }
    const double count = std::max<double>(1, static_cast<double>(order.size()));
    Eigen::Index axis = 0;
    (squares / count - (sum / count).cwiseAbs2()).maxCoeff(&axis);
    const auto box = [&](std::int32_t k) -> const Box3& { return boxes[static_cast<std::size_t>(k)]; };
    std::ranges::sort(order, [&](std::int32_t a, std::int32_t b) {
        return std::pair(box(a).lower[axis], a) < std::pair(box(b).lower[axis], b);
    });
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    for (std::size_t k = 0; k < order.size(); ++k)
        for (std::size_t l = k + 1; l < order.size() && box(order[l]).lower[axis] <= box(order[k]).upper[axis]; ++l)
            if (gap_of(box(order[k]), box(order[l])) <= 0)
                pairs.emplace_back(std::min(order[k], order[l]), std::max(order[k], order[l]));
    std::ranges::sort(pairs);
    return pairs;
}

Partners touching_partners(const std::vector<Box3>& boxes) {
    const auto pairs = touching_pairs(boxes);
    const auto at = [](std::int32_t box) { return static_cast<std::size_t>(box); };
    Partners out;
    out.begin.assign(boxes.size() + 1, 0);
    for (const auto& [a, b] : pairs) ++out.begin[at(a) + 1], ++out.begin[at(b) + 1];
    for (std::size_t k = 0; k < boxes.size(); ++k) out.begin[k + 1] += out.begin[k];
    out.partner.resize(out.begin.back());
    std::vector<std::size_t> next(out.begin.begin(), out.begin.end() - 1);
    // Pairs ascend: those in which a box is the second come before those in which it is the first.
    for (const auto& [a, b] : pairs) {
        out.partner[next[at(a)]++] = b;
        out.partner[next[at(b)]++] = a;
    }
    return out;
}

}  // namespace thixo
