#include "sim/surface/surroundings.h"

#include <algorithm>
#include <limits>

#include "pipeline/base/parallel.h"
#include "sim/surface/near_runs.h"

namespace thixo {
namespace {

constexpr Real kAgree = Real(0.70710678), kMayAgree = Real(0.5);  // cosines of 45 and 60 degrees

/// The nearest so far, kept in order.
struct Nearest {
    std::array<std::pair<Real, Index>, kNearest> found;
    Nearest() { found.fill({std::numeric_limits<Real>::max(), kNone}); }
    void offer(Real r2, Index j) {
        const std::pair<Real, Index> entry(r2, j);
        if (!(entry < found.back())) return;
        std::size_t k = kNearest - 1;
        for (; k > 0 && entry < found[k - 1]; --k) found[k] = found[k - 1];
        found[k] = entry;
    }
};

}  // namespace

void SurfelLists::list(Index i, const SurfelPlaces& surfels, Real reach) {
    std::vector<Index>& out = blocks_[i / kBlock];
    const Vec3 n = surfels.normal[i];
    const std::int32_t component = surfels.component[i];
    begin_[i] = static_cast<std::uint32_t>(out.size());
    Nearest nearest;
    for_each_in_box(grid_, surfels.position[i], reach, [&](Index slot, Real r2) {
        const Index j = grid_.index(slot);
        const Real agree = surfels.normal[j].dot(n);
        if (j == i || agree < kMayAgree || surfels.component[j] != component) return;
        out.push_back(j);
        if (agree >= kAgree) nearest.offer(r2, j);
    });
    count_[i] = static_cast<std::uint32_t>(out.size()) - begin_[i];
    for (std::size_t k = 0; k < kNearest; ++k) nearest_[i][k] = nearest.found[k].second;
}

void SurfelLists::build(const SurfelPlaces& surfels, const std::vector<Real>& radius, Real per_radius, Real margin) {
    const std::size_t n = surfels.size();
    margin_ = margin;
    listed_at_ = surfels.position;
    Real widest = 0;
    for (const Real r : radius) widest = std::max(widest, r);
    // Finer than the reach: surfels lie in sheets, and most of a large cell is not near.
    grid_.build(surfels.position, (per_radius * widest + margin) / 2);
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
        return (position[i] - listed_at_[i]).squaredNorm() > square(margin_ / 2) ? 1.0 : 0.0;
    });
    return away > 0.1 * static_cast<double>(position.size());
}

}  // namespace thixo
