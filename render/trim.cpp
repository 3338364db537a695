#include "render/trim.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/geometry/boolean_tree.h"

namespace thixo::render {
namespace {

using Op = TrimNode::Op;

/// De Morgan: the tree without differences; `turned` marks the layers that are taken away.
TrimNode without_differences(const TrimNode& node, bool negated, std::vector<signed char>& side) {
    if (node.op == Op::sheet) {
        signed char& sign = side.at(std::size_t(node.sheet));
        const signed char now = negated ? -1 : 1;
        if (sign == -now) throw CacheError("a trim tree both keeps and takes away sheet {}", node.sheet);
        sign = now;
        return node;
    }
    TrimNode result;
    result.reach = node.reach;
    const bool all = (node.op != Op::any) != negated;
    result.op = all ? Op::all : Op::any;
    for (std::size_t k = 0; k < node.parts.size(); ++k)
        result.parts.push_back(without_differences(node.parts[k], negated != (node.op == Op::except && k > 0), side));
    return result;
}

void check_sheets(const TrimNode& node, std::span<const Index> object, Index own) {
    if (node.op == Op::sheet && (std::size_t(node.sheet) >= object.size() || object[std::size_t(node.sheet)] != own))
        throw CacheError("a trim tree names sheet {}, which its body does not have", node.sheet);
    for (const TrimNode& part : node.parts) check_sheets(part, object, own);
}

/// Least squares over surfels. Along directions in which they do not spread, the velocity does not change.
AffineVelocity affine_velocity(const SurfelCloud& cloud, std::span<const Vec3f> velocity, std::vector<Index> surfels) {
    constexpr double kFlat = 1e-6;  // of the largest spread
    Vec3d place(0, 0, 0), mean(0, 0, 0);
    std::erase_if(surfels, [&](Index i) { return !cloud.position[i].allFinite() || !velocity[i].allFinite(); });
    for (const Index i : surfels) {
        place += cloud.position[i].cast<double>();
        mean += velocity[i].cast<double>();
    }
    if (surfels.empty()) return {};
    place /= double(surfels.size());
    mean /= double(surfels.size());
    Mat3d spread = Mat3d::Zero(), product = Mat3d::Zero();
    for (const Index i : surfels) {
        const Vec3d x = cloud.position[i].cast<double>() - place;
        spread += x * x.transpose();
        product += (velocity[i].cast<double>() - mean) * x.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Mat3d> axes(spread);
    Mat3d inverse = Mat3d::Zero();
    for (int k = 0; k < 3; ++k)
        if (const double s = axes.eigenvalues()[k]; s > kFlat * axes.eigenvalues()[2])
            inverse += axes.eigenvectors().col(k) * axes.eigenvectors().col(k).transpose() / s;
    const Mat3d gradient = product * inverse;
    if (!gradient.allFinite() || !mean.allFinite()) return {};
    return {place.cast<float>(), mean.cast<float>(), gradient.cast<float>()};
}

}  // namespace

Trims::Trims(const std::vector<std::optional<TrimNode>>& tree, std::span<const Index> object,
             std::span<const std::uint32_t> layer, SurfelCloud& cloud, std::span<const Vec3f> velocity) {
    std::vector<signed char> side(object.size(), 0);
    trees_.resize(tree.size());
    for (Index o = 0; o < tree.size(); ++o) {
        if (!tree[o]) continue;
        check_sheets(*tree[o], object, o);
        trees_[o] = without_differences(*tree[o], false, side);
    }
    std::vector<std::vector<Index>> members(object.size());
    for (Index i = 0; i < layer.size(); ++i) {
        if (side[layer[i]] == 0) continue;
        if (side[layer[i]] < 0) std::swap(cloud.axis1[i], cloud.axis2[i]);
        members[layer[i]].push_back(i);
    }
    fields_.resize(object.size());
    for (std::size_t l = 0; l < object.size(); ++l)
        if (side[l] != 0) fields_[l].emplace(cloud, members[l]);
    if (velocity.empty()) return;
    std::vector<std::vector<Index>> own(tree.size());
    for (std::size_t l = 0; l < object.size(); ++l)
        if (side[l] != 0) own[object[l]].insert(own[object[l]].end(), members[l].begin(), members[l].end());
    for (const std::vector<Index>& surfels : own) motion_.push_back(affine_velocity(cloud, velocity, surfels));
}

bool Trims::near(const TrimNode& node, const Vec3f& x, float reach) const {
    if (node.op == Op::sheet) return fields_[std::size_t(node.sheet)]->within(x, reach);
    return std::any_of(node.parts.begin(), node.parts.end(), [&](const TrimNode& p) { return near(p, x, reach); });
}

namespace {

template <class Side, class Holds>
struct Leaf {
    Side side;
    Holds beyond;
    unsigned operator()(const TrimNode& node) const { return side(node); }
    bool holds(const TrimNode& node) const { return beyond(node); }
};

}  // namespace

bool Trims::keeps(Index object, std::uint32_t layer, const Vec3f& place, float radius, float seconds) const {
    const Vec3f x = seconds == 0 || motion_.empty() ? place : motion_[object].before(place, seconds);
    const float overlap = kTrimOverlap * radius;
    const Leaf leaf{[&](const TrimNode& node) -> unsigned {
                        const auto l = std::uint32_t(node.sheet);
                        return l == layer ? unsigned(kOwnSide) : outcome_of_side(fields_[l]->distance(x), overlap);
                    },
                    [&](const TrimNode& node) { return node.reach > 0 && !near(node, x, node.reach); }};
    return outcomes(*trees_[object], leaf) & kOwnSide;
}

}  // namespace thixo::render
