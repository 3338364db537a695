// A grid of points in cubic cells that takes new points at any time, for surfaces that grow.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/base/random.h"

namespace thixo {

/// Cells stand in blocks of 4 x 4 x 4. Blocks with points are in an open-addressed table. Each cell has a chain of its
/// points, the latest first. The points that a query visits, and their order, depend on the points and the order of
/// adding alone.
class GrowingGrid {
  public:
    /// Cells have the edge `cell` > 0 [m]. A query of radius r visits at most (2 r/cell + 2)^3 of them.
    explicit GrowingGrid(Real cell, std::size_t expected = 0) : per_cell_(1 / cell) {
        rehash(expected / 8 + 64);
        point_.reserve(expected + expected / 4);
    }

    std::size_t size() const { return point_.size(); }

    /// Adds a point; its index is the number of points before it.
    void add(const Vec3& x) {
        if (2 * blocks_.size() >= slot_.size()) rehash(2 * slot_.size());
        const std::int32_t cx = coordinate(x.x()), cy = coordinate(x.y()), cz = coordinate(x.z());
        const std::uint64_t block = key(cx >> kBits, cy >> kBits, cz >> kBits);
        Index& slot = slot_[place(block)];
        if (slot == kNone) {
            slot = static_cast<Index>(blocks_.size());
            blocks_.push_back({block, {}});
            blocks_.back().first.fill(kNone);
        }
        Index& first = blocks_[slot].first[cell_in_block(cx, cy, cz)];
        point_.push_back({x, first});
        first = static_cast<Index>(point_.size() - 1);
    }

    /// Calls f(j, r2) for every point j with |x - x_j|^2 = r2 < radius^2.
    template <class F>
    void for_each_neighbour(const Vec3& x, Real radius, F&& f) const {
        any_neighbour(x, radius, [&](Index j, Real r2) {
            f(j, r2);
            return false;
        });
    }
    /// Whether f(j, r2) is true for one of them. The search ends at the first.
    template <class F>
    bool any_neighbour(const Vec3& x, Real radius, F&& f) const {
        const Real limit = radius * radius;
        const Range ax(coordinate(x.x() - radius), coordinate(x.x() + radius));
        const Range ay(coordinate(x.y() - radius), coordinate(x.y() + radius));
        const Range az(coordinate(x.z() - radius), coordinate(x.z() + radius));
        for (std::int32_t bz = az.first >> kBits; bz <= az.last >> kBits; ++bz)
            for (std::int32_t by = ay.first >> kBits; by <= ay.last >> kBits; ++by)
                for (std::int32_t bx = ax.first >> kBits; bx <= ax.last >> kBits; ++bx) {
                    const Index slot = slot_[place(key(bx, by, bz))];
                    if (slot == kNone) continue;
                    const Range rx = ax.within(bx), ry = ay.within(by), rz = az.within(bz);
                    for (std::int32_t cz = rz.first; cz <= rz.last; ++cz)
                        for (std::int32_t cy = ry.first; cy <= ry.last; ++cy)
                            for (std::int32_t cx = rx.first; cx <= rx.last; ++cx)
                                for (Index j = blocks_[slot].first[cell_in_block(cx, cy, cz)]; j != kNone;
                                     j = point_[j].next) {
                                    const Real r2 = (point_[j].position - x).squaredNorm();
                                    if (r2 < limit && f(j, r2)) return true;
                                }
                }
        return false;
    }

  private:
    static constexpr int kBits = 2, kEdge = 1 << kBits;  // cells along a block's edge
    struct Block {
        std::uint64_t key;
        std::array<Index, std::size_t(kEdge) * kEdge * kEdge> first;  // point of each cell; kNone: none
    };
    struct Point {
        Vec3 position;
        Index next;  // in the same cell
    };
    struct Range {
        std::int32_t first, last;
        Range(std::int32_t a, std::int32_t b) : first(a), last(b) {}
        Range within(std::int32_t block) const {
            return {std::max(first, block << kBits), std::min(last, (block << kBits) + kEdge - 1)};
        }
    };
    // Cells beyond the limit are folded into the outermost ones, as in PointGrid. So are values that are not numbers.
    std::int32_t coordinate(Real v) const {
        constexpr Real kLimit = (1 << 20) - 1;
        const Real c = std::floor(v * per_cell_);
        return static_cast<std::int32_t>(c > -kLimit ? (c < kLimit ? c : kLimit) : -kLimit);
    }
    static std::size_t cell_in_block(std::int32_t x, std::int32_t y, std::int32_t z) {
        constexpr std::int32_t mask = kEdge - 1;
        return static_cast<std::size_t>(((z & mask) << kBits | (y & mask)) << kBits | (x & mask));
    }
    static std::uint64_t key(std::int32_t x, std::int32_t y, std::int32_t z) {
        const auto part = [](std::int32_t v) { return static_cast<std::uint64_t>(v + (1 << 20)); };
        return part(z) << 42 | part(y) << 21 | part(x);
    }
    /// The slot of a block, or the free one where it belongs.
    std::size_t place(std::uint64_t block) const {
        std::size_t k = mix64(block) & (slot_.size() - 1);
        while (slot_[k] != kNone && blocks_[slot_[k]].key != block) k = (k + 1) & (slot_.size() - 1);
        return k;
    }
    void rehash(std::size_t least) {
        std::size_t size = 64;
        while (size < least) size *= 2;
        slot_.assign(size, kNone);
        for (Index b = 0; b < blocks_.size(); ++b) slot_[place(blocks_[b].key)] = b;
    }

    Real per_cell_;
    std::vector<Index> slot_;  // into blocks_; kNone: free
    std::vector<Block> blocks_;
    std::vector<Point> point_;
};

}  // namespace thixo
