#include "render/sheet_field.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "render/surfel_blocks.h"

namespace thixo::render {

struct SheetField::Sums {
    float weight = 0, along = 0, squares = 0, size = 0;
    Vec3f place = Vec3f::Zero(), normal = Vec3f::Zero();
};

SheetField::SheetField(const SurfelCloud& cloud, const std::vector<Index>& members) {
    for (const Index i : members) {
        const Vec3f &t1 = cloud.axis1[i], &t2 = cloud.axis2[i];
        const float area = t1.cross(t2).norm();
        if (!(area > 0) || !cloud.position[i].allFinite()) continue;
        Disc d;
        d.place = cloud.position[i];
        d.normal = t1.cross(t2) / area;
        d.size = std::sqrt(t1.norm() * t2.norm());
        d.height = kHeight * d.size;
        Mat3f axes;
        axes << kReach * t1, kReach * t2, d.height * d.normal;
        const Mat3f to_unit = axes.inverse();
        d.row1 = to_unit.row(0);
        d.row2 = to_unit.row(1);
        widest_ = std::max({widest_, axes.rowwise().norm().maxCoeff()});
        discs_.push_back(d);
    }
    find_plane();
    if (!discs_.empty()) lower_ = upper_ = discs_.front().place;
    for (const Disc& d : discs_) {
        lower_ = lower_.cwiseMin(d.place);
        upper_ = upper_.cwiseMax(d.place);
    }
    axis_.resize(discs_.size());
    sort(0, discs_.size(), 0);
}

/// Finds out whether all discs lie in one plane. Far from such a plane all discs are about equally near, so that a
/// search for the nearest would visit them all.
void SheetField::find_plane() {
    if (discs_.empty()) return;
    const Disc& first = discs_.front();
    flat_ = std::all_of(discs_.begin(), discs_.end(), [&](const Disc& d) {
        return (d.normal - first.normal).squaredNorm() < 1e-12f &&
               std::abs(first.normal.dot(d.place - first.place)) < 1e-5f * first.size;
    });
}

void SheetField::sort(std::size_t begin, std::size_t end, std::size_t node) {
    if (end - begin < 2) return;
    if (end - begin >= kBundle) {
        if (bundles_.size() <= node) bundles_.resize(node + 1);
        bundles_[node] = bundle(begin, end);
    }
    Vec3f lower = discs_[begin].place, upper = lower;
    for (std::size_t i = begin; i < end; ++i) {
        lower = lower.cwiseMin(discs_[i].place);
        upper = upper.cwiseMax(discs_[i].place);
    }
    int axis = 0;
    (upper - lower).maxCoeff(&axis);
    const std::size_t middle = (begin + end) / 2;
    const auto at = [&](std::size_t i) { return discs_.begin() + std::ptrdiff_t(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](const Disc& a, const Disc& b) {
        const Vec3f &p = a.place, &q = b.place;
        return std::tuple(p[axis], p.x(), p.y(), p.z()) < std::tuple(q[axis], q.x(), q.y(), q.z());
    });
    axis_[middle] = static_cast<unsigned char>(axis);
    sort(begin, middle, 2 * node + 1);
    sort(middle + 1, end, 2 * node + 2);
}

SheetField::Bundle SheetField::bundle(std::size_t begin, std::size_t end) const {
    Vec3f lower = discs_[begin].place, upper = lower, normal = Vec3f::Zero();
    float size = 0;
    for (std::size_t i = begin; i < end; ++i) {
        lower = lower.cwiseMin(discs_[i].place);
        upper = upper.cwiseMax(discs_[i].place);
        normal += discs_[i].normal;
        size = std::max(size, discs_[i].size);
    }
    Bundle b{(lower + upper) / 2, (upper - lower) / 2, normal.normalized(), 1, 0, 1e-3f * size};
    for (std::size_t i = begin; i < end; ++i) b.cosine = std::min(b.cosine, b.normal.dot(discs_[i].normal));
    b.sine = std::sqrt(std::max(1 - square(b.cosine), 0.0f));
    return b;
}

/// Take the plane through any place in the box with any normal in the cone. With the cone's cosine and sine the height
/// of x above this plane is at least
///
///     cosine (least height along the axis) - sine (largest distance from the axis)   [m]
int SheetField::Bundle::side(const Vec3f& x) const {
    if (!(cosine > 0)) return 0;
    const Vec3f v = x - centre;
    const float along = normal.dot(v), reach = normal.cwiseAbs().dot(half);
    const float least = std::abs(along) - reach;
    if (least <= 0) return 0;
    const float across = std::sqrt(std::max(v.squaredNorm() - square(along), 0.0f)) + half.norm();
    if (cosine * least - sine * across <= margin) return 0;
    return along > 0 ? 1 : -1;
}

void SheetField::gather(std::size_t begin, std::size_t end, const Vec3f& x, Sums& sums) const {
    if (begin >= end) return;
    const std::size_t middle = (begin + end) / 2;
    const Disc& d = discs_[middle];
    const float side = x[axis_[middle]] - d.place[axis_[middle]];
    if (side < widest_) gather(begin, middle, x, sums);
    const Vec3f y = d.place - x;
    const float along = d.normal.dot(y);
    const float q = 1 - square(d.row1.dot(y)) - square(d.row2.dot(y)) - square(along / d.height);
    if (q > 0) {
        const float w = cube(q);
        sums.weight += w;
        sums.size += w * d.size;
        sums.place += w * y;
        sums.normal += w * d.normal;
        sums.along += w * along;
        sums.squares += w * y.squaredNorm();
    }
    if (side > -widest_) gather(middle + 1, end, x, sums);
}

/// `away` is how far x is from the range's box along each axis. Its square is the least that a disc of the range can be
/// away (Arya and Mount 1993). The search goes by bundles. Where x is on one side of all discs of a bundle, the nearest
/// of them need not be found. That holds while all others that could be nearer give the same side; else it is disputed.
template <bool by_bundles>
void SheetField::nearest(std::size_t begin, std::size_t end, std::size_t node, const Vec3f& x, Vec3f& away,
                         Nearest& best) const {
    if (begin >= end || away.squaredNorm() >= best.distance2 || best.disputed) return;
    const std::size_t middle = (begin + end) / 2;
    const Disc& d = discs_[middle];
    const auto height = [&](const Disc& disc) { return disc.normal.dot(x - disc.place); };
    const auto agrees = [&](float h) { return !best.disc || (height(*best.disc) > 0) == (h > 0); };
    const float r2 = (d.place - x).squaredNorm();
    const int side = by_bundles && end - begin >= kBundle ? bundles_[node].side(x) : 0;
    if (by_bundles && (side != 0 || r2 < best.distance2)) best.disputed = !agrees(side != 0 ? float(side) : height(d));
    if (r2 < best.distance2) best.distance2 = r2, best.disc = &d;
    if (side != 0) return;
    const int axis = axis_[middle];
    const float beyond = x[axis] - d.place[axis], before = away[axis];
    const auto search = [&](bool upper) {
        upper ? nearest<by_bundles>(middle + 1, end, 2 * node + 2, x, away, best)
              : nearest<by_bundles>(begin, middle, 2 * node + 1, x, away, best);
    };
    search(beyond >= 0);
    away[axis] = beyond;
    search(beyond < 0);
    away[axis] = before;
}

/// Over the plane of the nearest disc, or of another with x on the same side.
float SheetField::far_distance(const Vec3f& x) const {
    Vec3f away = Vec3f::Zero();
    Nearest best;
    nearest<true>(0, discs_.size(), 0, x, away, best);
    if (best.disputed) {
        away.setZero();
        best = {};
        nearest<false>(0, discs_.size(), 0, x, away, best);
    }
    return best.disc ? best.disc->normal.dot(x - best.disc->place) : best.distance2;
}

bool SheetField::within(const Vec3f& x, float reach) const {
    Vec3f away = (lower_ - x).cwiseMax(x - upper_).cwiseMax(0);
    if (discs_.empty() || away.squaredNorm() >= square(reach)) return false;
    away.setZero();
    Nearest best{.distance2 = square(reach)};
    nearest<false>(0, discs_.size(), 0, x, away, best);
    return best.disc != nullptr;
}

float SheetField::distance(const Vec3f& x) const {
    if (discs_.empty()) return std::numeric_limits<float>::max();
    if (flat_) return discs_.front().normal.dot(x - discs_.front().place);
    Sums sums;
    gather(0, discs_.size(), x, sums);
    if (!(sums.weight > 1e-9f)) return far_distance(x);
    const Vec3f place = sums.place / sums.weight, normal = sums.normal / sums.weight;
    const float size = sums.size / sums.weight, spread = sums.squares / sums.weight - place.squaredNorm();
    const float bend = std::clamp(
        (sums.along / sums.weight - place.dot(normal)) / std::max(spread, 1e-3f * square(size)), -1 / size, 1 / size);
    const Vec3f gradient = normal - bend * place;
    return -(gradient.dot(place) + 0.5f * bend * (spread + place.squaredNorm()));
}

}  // namespace thixo::render
