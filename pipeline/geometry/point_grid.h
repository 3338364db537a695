// Fixed-radius neighbours by a cell-linked grid over points sorted in cell order; k nearest on top of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/base/math.h"

namespace thixo {

/// Grid with cells of one support radius over the occupied box. The points must be in cell order when `build` is called without a
/// permutation (see `sort_order`); neighbours of a cell row are then contiguous in memory.
class PointGrid {
  public:
    /// Cells of edge `cell` [m]. Memory is bounded: where the occupied box would have too many cells, cells are hashed by sorted keys.
    /// The result of every query is independent of the thread count, order included: ascending index within a cell, cells in fixed order.
    void build(std::span<const Vec3> points, Real cell);

    /// The permutation that sorts points by (cell key, id): new element k is old element order[k]. Deterministic.
    static std::vector<Index> sort_order(std::span<const Vec3> points, std::span<const std::int64_t> ids, Real cell);

    Real cell() const { return cell_; }

    /// Calls f(j) for every point j in the 27 cells around x (all points with |x - x_j| < cell are among them).
    template <class F>
    void for_each_candidate(const Vec3& x, F&& f) const;

    /// Calls f(j, r2) for every point j with |x - x_j|^2 = r2 < radius^2. Requires radius <= cell.
    template <class F>
    void for_each_neighbour(const Vec3& x, Real radius, F&& f) const;

    /// The k nearest points to x (ties by index), nearest first, searched in growing rings of cells up to max_radius.
    void nearest(const Vec3& x, int k, Real max_radius, std::vector<std::pair<Real, Index>>& found) const;
};

}  // namespace thixo
