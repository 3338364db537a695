#include "sim/surface/surroundings.h"

#include <algorithm>
#include <limits>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/near_runs.h"

namespace thixo {
namespace {

constexpr Real kAgree = Real(0.70710678), kMayAgree = Real(0.5);  // cosines of 45 and 60 degrees

/// The nearest so far, in order. Of equally near ones that of the smaller index comes first.
struct Nearest {
    std::array<Real, kNearest> r2;
    std::array<Index, kNearest> found;
    Nearest() {
        r2.fill(std::numeric_limits<Real>::max());
        found.fill(kNone);
    }
    void offer(Real d2, Index j) {
        if (d2 > r2.back() || (d2 == r2.back() && j > found.back())) return;
        std::size_t k = kNearest - 1;
        for (; k > 0 && (d2 < r2[k - 1] || (d2 == r2[k - 1] && j < found[k - 1])); --k) {
            r2[k] = r2[k - 1];
            found[k] = found[k - 1];
        }
        r2[k] = d2;
        found[k] = j;
    }
};

}  // namespace

void SurfelLists::list(Index i, const SurfelPlaces& surfels, Real reach) {
    std::vector<Index>& out = blocks_[i / kBlock];
    const Vec3 n = surfels.normal[i];
    const std::int32_t component = surfels.component[i];
    begin_[i] = static_cast<std::uint32_t>(out.size());
    Nearest nearest;
    constexpr std::size_t kBatch = 128;
    Index batch[kBatch];
    std::size_t count = 0;
    const Lanes limit = all_lanes(reach * reach), may_agree = all_lanes(kMayAgree);
    for_each_box_run(grid_, surfels.position[i], reach, [&](Index slot, Index lanes, Lanes r2) {
        const Lanes agree =
            load_lanes(&nx_[slot]) * n.x() + load_lanes(&ny_[slot]) * n.y() + load_lanes(&nz_[slot]) * n.z();
        for_each_set_lane((r2 < limit) & (agree >= may_agree), [&](Index l) {
            if (l >= lanes) return;
            const Index j = grid_.index(slot + l);
            if (j == i || component_[slot + l] != component) return;
            if (count == kBatch) {
                out.insert(out.end(), batch, batch + count);
                count = 0;
            }
            batch[count++] = j;
            if (agree[l] >= kAgree) nearest.offer(r2[l], j);
        });
    });
    out.insert(out.end(), batch, batch + count);
    count_[i] = static_cast<std::uint32_t>(out.size()) - begin_[i];
    nearest_[i] = nearest.found;
}

void SurfelLists::build(const SurfelPlaces& surfels, const std::vector<Real>& radius, Real per_radius, Real margin) {
    const std::size_t n = surfels.size();
    margin_ = margin;
    listed_at_ = surfels.position;
    Real widest = 0;
    for (const Real r : radius) widest = std::max(widest, r);
    grid_.build(surfels.position, per_radius * widest + margin);
    for (auto* a : {&nx_, &ny_, &nz_}) a->resize(n + PointGrid::kPadding, 0);
    component_.resize(n);
    parallel_for(n, [&](std::size_t slot) {
        const Index i = grid_.index(static_cast<Index>(slot));
        const Vec3& normal = surfels.normal[i];
        component_[slot] = surfels.component[i];
        nx_[slot] = normal.x();
        ny_[slot] = normal.y();
        nz_[slot] = normal.z();
    });
    blocks_.resize((n + kBlock - 1) / kBlock);
    begin_.resize(n);
    count_.resize(n);
    nearest_.resize(n);
    const auto list_block = [&](std::size_t begin, std::size_t end, std::size_t block) {
        blocks_[block].clear();
        for (std::size_t i = begin; i < end; ++i) list(static_cast<Index>(i), surfels, per_radius * radius[i] + margin);
    };
    parallel_chunks(n, list_block, kBlock);
}

bool SurfelLists::stale(const std::vector<Vec3>& position) const {
    if (listed_at_.size() != position.size()) return true;
    const double away = parallel_sum(position.size(), [&](std::size_t i) {
        return (position[i] - listed_at_[i]).squaredNorm() > square(margin_) ? 1.0 : 0.0;
    });
    return away > 0.1 * static_cast<double>(position.size());
}

}  // namespace thixo
