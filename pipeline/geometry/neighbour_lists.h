// Neighbours of all points at once. They are kept for the sweeps that use them several times in one step.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <span>
#include <vector>

#include "pipeline/geometry/point_grid.h"

namespace thixo {

/// For every point i of a grid the indices j != i with |x_i - x_j| < radius, in the order of the grid. They ascend
/// where the points are in cell order. The lists are the same at any thread count. Storage is kept between builds, so
/// that a simulation of constant size allocates nothing.
class NeighbourLists {
  public:
    /// Requires radius <= grid.cell() [m].
    void build(const PointGrid& grid, Real radius) { build(grid, radius, grid.size()); }

    /// Makes lists for the first `count` points alone. All points may appear in them.
    void build(const PointGrid& grid, Real radius, std::size_t count);

    /// The same for places that are no points of the grid: for every query q all points j with |q - x_j| < radius. It
    /// is fastest where consecutive queries lie near each other.
    void build(const PointGrid& grid, std::span<const Vec3> queries, Real radius);

    std::size_t size() const { return begin_.size(); }
    /// Neighbours of point i, without itself, or of query i. Another point in the same place is a neighbour.
    std::span<const Index> operator[](std::size_t i) const {
        return {blocks_[block_.empty() ? i / kBlock : block_[i]].data() + begin_[i], count_[i]};
    }
    /// Sum of the lengths of all lists.
    std::size_t total() const;

  private:
    /// The slots that can be neighbours of the points of one cell.
    struct Candidates {
        std::vector<Real> x, y, z;
        std::vector<Index> slot;
        std::size_t count = 0;
        void make_room(std::size_t more);
    };
    struct Scratch {
        Candidates candidates;
        std::vector<Index> indices;  // of the current block
    };
    static constexpr std::size_t kBlock = 1024;
    void resize(std::size_t lists, std::size_t places, bool in_order);
    void fill(const PointGrid& grid, const Vec3* queries, Real radius, Index begin, Index end, std::uint32_t block);

    std::vector<std::vector<Index>> blocks_;  // one for each fixed chunk of slots, with all of its lists
    std::vector<std::uint32_t> block_;        // block of each list; empty: kBlock consecutive lists share one
    std::vector<std::uint32_t> begin_, count_;
    oneapi::tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace thixo
