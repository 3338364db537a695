// Points in cubic cells that takes new points at any time: what a surface that grows is looked up in.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/base/random.h"

namespace thixo {

/// An open-addressed table of the occupied cells, each with the chain of its points, the latest first. What a query
/// visits and in which order depends on the points and the order of their adding alone.
class GrowingGrid {
  public:
    /// Cells of edge `cell` > 0 [m]; a query of radius r visits (2 r/cell + 2)^3 of them at most.
    explicit GrowingGrid(Real cell, std::size_t expected = 0) : per_cell_(1 / cell) { rehash(2 * expected + 64); }

    std::size_t size() const { return point_.size(); }

    /// Adds a point; its index is the number of points before it.
    void add(const Vec3& x) {
        if (2 * cells_ >= slot_.size()) rehash(2 * slot_.size());
        const auto i = static_cast<Index>(point_.size());
        Slot& slot = find(key(coordinate(x.x()), coordinate(x.y()), coordinate(x.z())));
        if (slot.first == kNone) ++cells_;
        point_.push_back({x, slot.first});
        slot.key = key(coordinate(x.x()), coordinate(x.y()), coordinate(x.z()));
        slot.first = i;
    }

    /// Calls f(j, r2) for every point j with |x - x_j|^2 = r2 < radius^2.
    template <class F>
    void for_each_neighbour(const Vec3& x, Real radius, F&& f) const {
        const Real limit = radius * radius;
        const std::int32_t x0 = coordinate(x.x() - radius), x1 = coordinate(x.x() + radius);
        const std::int32_t y0 = coordinate(x.y() - radius), y1 = coordinate(x.y() + radius);
        const std::int32_t z0 = coordinate(x.z() - radius), z1 = coordinate(x.z() + radius);
        for (std::int32_t cz = z0; cz <= z1; ++cz)
            for (std::int32_t cy = y0; cy <= y1; ++cy)
                for (std::int32_t cx = x0; cx <= x1; ++cx)
                    for (Index j = find(key(cx, cy, cz)).first; j != kNone; j = point_[j].next) {
                        const Real r2 = (point_[j].position - x).squaredNorm();
                        if (r2 < limit) f(j, r2);
                    }
    }

  private:
    struct Slot {
        std::uint64_t key = 0;
        Index first = kNone;  // kNone: the slot is free
    };
    struct Point {
        Vec3 position;
        Index next;  // in the same cell
    };
    // Cells beyond the limit are folded into the outermost ones, as PointGrid's are; so is what is not a number.
    std::int32_t coordinate(Real v) const {
        constexpr Real kLimit = (1 << 20) - 1;
        const Real c = std::floor(v * per_cell_);
        return static_cast<std::int32_t>(c > -kLimit ? (c < kLimit ? c : kLimit) : -kLimit);
    }
    static std::uint64_t key(std::int32_t x, std::int32_t y, std::int32_t z) {
        const auto part = [](std::int32_t v) { return static_cast<std::uint64_t>(v + (1 << 20)); };
        return part(z) << 42 | part(y) << 21 | part(x);
    }
    /// The slot of a cell, or the free one where it belongs.
    const Slot& find(std::uint64_t cell) const {
        std::size_t k = mix64(cell) & (slot_.size() - 1);
        while (slot_[k].first != kNone && slot_[k].key != cell) k = (k + 1) & (slot_.size() - 1);
        return slot_[k];
    }
    Slot& find(std::uint64_t cell) { return const_cast<Slot&>(static_cast<const GrowingGrid*>(this)->find(cell)); }
    void rehash(std::size_t least) {
        std::size_t size = 64;
        while (size < least) size *= 2;
        std::vector<Slot> old(size);
        slot_.swap(old);
        for (const Slot& s : old)
            if (s.first != kNone) find(s.key) = s;
    }

    Real per_cell_;
    std::vector<Slot> slot_;
    std::vector<Point> point_;
    std::size_t cells_ = 0;
};

}  // namespace thixo
