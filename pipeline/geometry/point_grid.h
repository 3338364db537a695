// Neighbours within a radius by a grid over points in cell order, and k nearest neighbours by the same grid.
// Source: dissertation 7.1.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pipeline/base/math.h"

namespace thixo {

/// A grid of cubic cells, aligned to the world's origin. It holds its own copy of the points, sorted by (z, y, x) of
/// their cells. Three cells side by side along x are then one contiguous range, and a query walks nine ranges. Reported
/// indices are those of the caller's points.
///
/// Memory is bounded by the number of points, wherever they lie. Mostly a table holds the first slot of each cell.
/// Where the occupied box has far more cells than points, binary search over sorted keys finds the cells instead. It
/// searches one row of cells where a table of the rows is small enough. Results depend neither on the thread count nor
/// on which of these is in use. Points that are not finite are never found.
class PointGrid {
  public:
    /// Builds the grid over `points` with cells of the edge `cell` [m]. Points that are in cell order already (see
    /// `sort_order`) are recognised: building is cheapest for them, and reported indices ascend. Asserts cell > 0 and
    /// fewer than 2^32 - 1 points.
    void build(std::span<const Vec3> points, Real cell);

    /// The permutation that sorts points by (cell key, id): new element k is old element order[k]. A pure function of
    /// its arguments.
    static std::vector<Index> sort_order(std::span<const Vec3> points, std::span<const std::int64_t> ids, Real cell);

    Real cell() const { return cell_; }
    std::size_t size() const { return count_; }

    /// Calls f(j) for every point j in the 27 cells around x. All points with |x - x_j| < cell are among them.
    template <class F>
    void for_each_candidate(const Vec3& x, F&& f) const;

    /// Calls f(j, r2) for every point j with |x - x_j|^2 = r2 < radius^2, in the order of the grid. Requires radius <=
    /// cell.
    template <class F>
    void for_each_neighbour(const Vec3& x, Real radius, F&& f) const;

    /// The k nearest points to x within max_radius [m] as (squared distance, index), nearest first, ties by index.
    /// Searches rings of cells from the inside, so that the cost does not depend on max_radius where k points are near.
    void nearest(const Vec3& x, int k, Real max_radius, std::vector<std::pair<Real, Index>>& found) const;

    // ---- layout, for sweeps cell by cell (see NeighbourLists) -------------------------------------------------------
    struct Cell {
        std::int32_t x, y, z;
    };
    struct Range {
        Index begin, end;  // slots
    };
    /// Coordinates of slots: a slot is a place in the grid's order. They can be read kPadding places past the last.
    static constexpr std::size_t kPadding = 16;
    const Real* x() const { return x_.data(); }
    const Real* y() const { return y_.data(); }
    const Real* z() const { return z_.data(); }
    /// Index of the caller's point in a slot, and whether slots and indices are equal everywhere.
    Index index(Index slot) const { return order_.empty() ? slot : order_[slot]; }
    bool identity() const { return order_.empty(); }
    Cell cell_of(const Vec3& p) const {
        return {coordinate(p.x(), edge_inv_), coordinate(p.y(), edge_inv_), coordinate(p.z(), edge_inv_)};
    }
    Cell cell_of_slot(Index slot) const { return cell_of(Vec3(x_[slot], y_[slot], z_[slot])); }
    /// Slots of the cells (x0..x1, y, z); empty outside the occupied box.
    Range row(std::int32_t x0, std::int32_t x1, std::int32_t y, std::int32_t z) const {
        x0 = std::max(x0, lower_.x);
        x1 = std::min(x1, upper_.x);
        if (x0 > x1 || y < lower_.y || y > upper_.y || z < lower_.z || z > upper_.z) return {0, 0};
        return start_.empty() ? sparse_row(x0, x1, y, z)
                              : Range{start_[dense_key(x0, y, z)], start_[dense_key(x1, y, z) + 1]};
    }

  private:
    // Cells beyond the limit are folded into the outermost ones. This makes distances in cells smaller, never larger,
    // so that no pair is lost.
    static constexpr std::int32_t kLimit = (1 << 20) - 1;
    static std::int32_t coordinate(Real v, double edge_inv) {
        const double c = std::floor(static_cast<double>(v) * edge_inv);
        return static_cast<std::int32_t>(c > -kLimit ? (c < kLimit ? c : kLimit) : -kLimit);
    }
    static std::uint64_t key(const Cell& c) {
        const auto part = [](std::int32_t v) { return static_cast<std::uint64_t>(v + kLimit + 1); };
        return part(c.z) << 42 | part(c.y) << 21 | part(c.x);
    }
    static double edge_inverse(Real cell);
    static std::vector<Index> order_by(std::span<const std::uint64_t> keys, std::span<const std::int64_t> ids);
    std::size_t dense_key(std::int32_t x, std::int32_t y, std::int32_t z) const {
        return (static_cast<std::size_t>(z - lower_.z) * rows_ + static_cast<std::size_t>(y - lower_.y)) * columns_ +
               static_cast<std::size_t>(x - lower_.x);
    }
    Range sparse_row(std::int32_t x0, std::int32_t x1, std::int32_t y, std::int32_t z) const;
    void store_keys(std::span<const Vec3> points);
    void index_cells(std::span<const Vec3> points);
    void index_rows(std::size_t layers);

    Real cell_ = 0;
    double edge_inv_ = 0;  // 1 / edge [1/m]; the edge exceeds `cell` by a part in 10^5, so that rounding loses no pair
    std::size_t count_ = 0;
    Cell lower_{0, 0, 0}, upper_{-1, -1, -1};  // occupied box of cells, inclusive
    std::size_t columns_ = 0, rows_ = 0;
    std::vector<Real> x_, y_, z_;
    std::vector<Index> order_;         // slot -> caller's index; empty: the same
    std::vector<Index> start_;         // dense: first slot of each cell of the box, and the end
    std::vector<std::uint64_t> keys_;  // sparse: key of each slot
    std::vector<Index> row_start_;     // sparse: first slot of each row of cells along x, and the end; may be empty
};

template <class F>
void PointGrid::for_each_candidate(const Vec3& x, F&& f) const {
    const Cell c = cell_of(x);
    for (std::int32_t z = c.z - 1; z <= c.z + 1; ++z)
        for (std::int32_t y = c.y - 1; y <= c.y + 1; ++y) {
            const Range range = row(c.x - 1, c.x + 1, y, z);
            for (Index slot = range.begin; slot < range.end; ++slot) f(index(slot));
        }
}

template <class F>
void PointGrid::for_each_neighbour(const Vec3& x, Real radius, F&& f) const {
    const Cell c = cell_of(x);
    const Real limit = radius * radius;
    for (std::int32_t z = c.z - 1; z <= c.z + 1; ++z)
        for (std::int32_t y = c.y - 1; y <= c.y + 1; ++y) {
            const Range range = row(c.x - 1, c.x + 1, y, z);
            for (Index slot = range.begin; slot < range.end; slot += 8) {
                // Eight distances at once. Those past the end are computed and ignored.
                Real r2[8];
                for (int l = 0; l < 8; ++l)
                    r2[l] = square(x_[slot + l] - x.x()) + square(y_[slot + l] - x.y()) + square(z_[slot + l] - x.z());
                const Index lanes = std::min<Index>(8, range.end - slot);
                for (Index l = 0; l < lanes; ++l)
                    if (r2[l] < limit) f(index(slot + l), r2[l]);
            }
        }
}

}  // namespace thixo
