// Neighbours among the surfels: S_i and S_sub of dissertation 6.6.2.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pipeline/geometry/point_grid.h"

namespace thixo {

inline constexpr std::size_t kNearest = 10;  // |S_sub|

/// Surfels to be listed.
struct SurfelPlaces {
    const std::vector<Vec3>& position;
    const std::vector<Vec3>& normal;
    const std::vector<std::int32_t>& component;
    std::size_t size() const { return position.size(); }
};

class SurfelLists {
  public:
    /// Lists for every surfel i those of its component within per_radius * radius[i] + margin [m] whose normals are
    /// within 60 degrees of its own. The ten nearest of those within 45 degrees are listed as well. These are
    /// neighbours on one side of a body, with a margin in place and direction before the lists are stale.
    void build(const SurfelPlaces& surfels, const std::vector<Real>& radius, Real per_radius, Real margin);

    std::size_t size() const { return begin_.size(); }
    std::span<const Index> near(std::size_t i) const { return {blocks_[i / kBlock].data() + begin_[i], count_[i]}; }
    /// Nearest first; kNone where there are fewer.
    const std::array<Index, kNearest>& nearest(std::size_t i) const { return nearest_[i]; }

    /// Whether more than one surfel in ten has left its listed place by the margin. Fewer are strays: they miss
    /// neighbours of little weight, as do surfels that move together. True before the first build.
    bool stale(const std::vector<Vec3>& position) const;

  private:
    static constexpr std::size_t kBlock = 128;  // surfels listed in one block, by one thread
    void list(Index i, const SurfelPlaces& surfels, Real reach);

    PointGrid grid_;
    std::vector<Real> nx_, ny_, nz_;  // normals by slot
    std::vector<std::int32_t> component_;
    std::vector<std::vector<Index>> blocks_;
    std::vector<std::uint32_t> begin_, count_;
    std::vector<std::array<Index, kNearest>> nearest_;
    std::vector<Vec3> listed_at_;
    Real margin_ = 0;
};

}  // namespace thixo
