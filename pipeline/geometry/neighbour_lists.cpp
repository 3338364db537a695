#include "pipeline/geometry/neighbour_lists.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

// Row m lists the lanes that are set in the 8-bit mask m, in order. As a permutation it moves them to the front.
constexpr std::array<std::array<std::uint32_t, 8>, 256> front_lanes() {
    std::array<std::array<std::uint32_t, 8>, 256> table{};
    for (unsigned mask = 0; mask < 256; ++mask) {
        unsigned n = 0;
        for (unsigned lane = 0; lane < 8; ++lane)
            if (mask & (1u << lane)) table[mask][n++] = lane;
    }
    return table;
}
alignas(32) constexpr auto kFrontLanes = front_lanes();

/// The box around the points that share candidates.
struct Around {
    Vec3 lower, upper;
};

/// Arrays of coordinates.
template <class T>
struct Coordinates {
    T *x, *y, *z;
};

// In float, eight candidates are tested at a time, and those that pass are stored side by side. Every store writes
// eight places. The places past the last that passed are overwritten or never read.

[[maybe_unused]] __m256i front(unsigned mask) {
    return _mm256_load_si256(reinterpret_cast<const __m256i*>(kFrontLanes[mask].data()));
}

/// Writes those of the slots begin..end - 1 that lie within sqrt(limit) of the box to `near` and `slots`. Returns how
/// many there are. Reads up to 7 slots past the end.
[[maybe_unused]] std::size_t append_near(Coordinates<const float> at, Index begin, Index end, const Around& box,
                                         float limit, Coordinates<float> near, Index* slots) {
    const __m256 lx = _mm256_set1_ps(box.lower.x()), ly = _mm256_set1_ps(box.lower.y()),
                 lz = _mm256_set1_ps(box.lower.z()), ux = _mm256_set1_ps(box.upper.x()),
                 uy = _mm256_set1_ps(box.upper.y()), uz = _mm256_set1_ps(box.upper.z()), l2 = _mm256_set1_ps(limit),
                 zero = _mm256_setzero_ps();
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const auto beyond = [&](__m256 v, __m256 lower, __m256 upper) {
        return _mm256_max_ps(zero, _mm256_max_ps(_mm256_sub_ps(lower, v), _mm256_sub_ps(v, upper)));
    };
    std::size_t found = 0;
    for (Index slot = begin; slot < end; slot += 8) {
        const __m256 px = _mm256_loadu_ps(at.x + slot), py = _mm256_loadu_ps(at.y + slot),
                     pz = _mm256_loadu_ps(at.z + slot);
        const __m256 dx = beyond(px, lx, ux), dy = beyond(py, ly, uy), dz = beyond(pz, lz, uz);
        const __m256 r2 = _mm256_fmadd_ps(dz, dz, _mm256_fmadd_ps(dy, dy, _mm256_mul_ps(dx, dx)));
        auto mask = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(r2, l2, _CMP_LT_OQ)));
        if (end - slot < 8) mask &= (1u << (end - slot)) - 1;
        const __m256i order = front(mask);
        _mm256_storeu_ps(near.x + found, _mm256_permutevar8x32_ps(px, order));
        _mm256_storeu_ps(near.y + found, _mm256_permutevar8x32_ps(py, order));
        _mm256_storeu_ps(near.z + found, _mm256_permutevar8x32_ps(pz, order));
        const __m256i ids = _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(slot)), lanes);
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(slots + found), _mm256_permutevar8x32_epi32(ids, order));
        found += static_cast<std::size_t>(__builtin_popcount(mask));
    }
    return found;
}

/// Writes candidate[k] to `out`, in order, for every k < n with
///     |at_k - p|^2 < limit
/// Returns how many there are. Reads and writes up to 7 places past the end. Unused places of the arrays hold infinity.
[[maybe_unused]] std::size_t append_within(Coordinates<const float> at, const Index* candidate, std::size_t n,
                                           const Vec3f& p, float limit, Index* out) {
    const __m256 px = _mm256_set1_ps(p.x()), py = _mm256_set1_ps(p.y()), pz = _mm256_set1_ps(p.z()),
                 l2 = _mm256_set1_ps(limit);
    std::size_t found = 0;
    for (std::size_t k = 0; k < n; k += 8) {
        const __m256 dx = _mm256_sub_ps(_mm256_loadu_ps(at.x + k), px);
        const __m256 dy = _mm256_sub_ps(_mm256_loadu_ps(at.y + k), py);
        const __m256 dz = _mm256_sub_ps(_mm256_loadu_ps(at.z + k), pz);
        const __m256 r2 = _mm256_fmadd_ps(dz, dz, _mm256_fmadd_ps(dy, dy, _mm256_mul_ps(dx, dx)));
        const auto mask = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(r2, l2, _CMP_LT_OQ)));
        const __m256i ids = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(candidate + k));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + found), _mm256_permutevar8x32_epi32(ids, front(mask)));
        found += static_cast<std::size_t>(__builtin_popcount(mask));
    }
    return found;
}

[[maybe_unused]] std::size_t append_near(Coordinates<const double> at, Index begin, Index end, const Around& box,
                                         double limit, Coordinates<double> near, Index* slots) {
    std::size_t found = 0;
    for (Index slot = begin; slot < end; ++slot) {
        const Vec3d p(at.x[slot], at.y[slot], at.z[slot]), lower = box.lower.cast<double>(),
                                                           upper = box.upper.cast<double>();
        if (!((lower - p).cwiseMax(p - upper).cwiseMax(Vec3d::Zero()).squaredNorm() < limit)) continue;
        near.x[found] = p.x();
        near.y[found] = p.y();
        near.z[found] = p.z();
        slots[found++] = slot;
    }
    return found;
}

[[maybe_unused]] std::size_t append_within(Coordinates<const double> at, const Index* candidate, std::size_t n,
                                           const Vec3d& p, double limit, Index* out) {
    std::size_t found = 0;
    for (std::size_t k = 0; k < n; ++k) {
        out[found] = candidate[k];
        found += square(at.x[k] - p.x()) + square(at.y[k] - p.y()) + square(at.z[k] - p.z()) < limit ? 1 : 0;
    }
    return found;
}

}  // namespace

void NeighbourLists::resize(std::size_t lists, std::size_t places, bool in_order) {
    block_.resize(in_order ? 0 : lists);
    begin_.resize(lists);
    count_.resize(lists);
    blocks_.resize((places + kBlock - 1) / kBlock);
}

void NeighbourLists::build(const PointGrid& grid, Real radius, std::size_t count) {
    THIXO_ASSERT(radius <= grid.cell(), "radius {} exceeds the cell {}", radius, grid.cell());
    resize(std::min(count, grid.size()), grid.size(), grid.identity());
    parallel_chunks(
        grid.size(),
        [&](std::size_t begin, std::size_t end, std::size_t chunk) {
            fill(grid, nullptr, radius, static_cast<Index>(begin), static_cast<Index>(end),
                 static_cast<std::uint32_t>(chunk));
        },
        kBlock);
}

void NeighbourLists::build(const PointGrid& grid, std::span<const Vec3> queries, Real radius) {
    THIXO_ASSERT(radius <= grid.cell(), "radius {} exceeds the cell {}", radius, grid.cell());
    resize(queries.size(), queries.size(), true);
    parallel_chunks(
        queries.size(),
        [&](std::size_t begin, std::size_t end, std::size_t chunk) {
            fill(grid, queries.data(), radius, static_cast<Index>(begin), static_cast<Index>(end),
                 static_cast<std::uint32_t>(chunk));
        },
        kBlock);
}

void NeighbourLists::Candidates::make_room(std::size_t more) {
    const std::size_t room = count + more + PointGrid::kPadding;
    if (slot.size() >= room) return;
    for (auto* array : {&x, &y, &z}) array->resize(2 * room);
    slot.resize(2 * room);
}

/// Makes the lists of the slots (or queries) begin..end - 1. Points of one cell share their candidates: the points of
/// the 27 cells around it that lie within the radius of the box around them.
void NeighbourLists::fill(const PointGrid& grid, const Vec3* queries, Real radius, Index begin, Index end,
                          std::uint32_t block) {
    Scratch& scratch = scratch_.local();
    Candidates& c = scratch.candidates;
    const Real limit = radius * radius;
    const auto point = [&](Index slot) {
        return queries ? queries[slot] : Vec3(grid.x()[slot], grid.y()[slot], grid.z()[slot]);
    };
    const auto collect = [&](const PointGrid::Cell& cell, const Around& box) {
        c.count = 0;
        for (std::int32_t z = cell.z - 1; z <= cell.z + 1; ++z)
            for (std::int32_t y = cell.y - 1; y <= cell.y + 1; ++y) {
                const auto row = grid.row(cell.x - 1, cell.x + 1, y, z);
                c.make_room(row.end - row.begin);
                // The margin is for double, where the two sums may be rounded differently. In float it costs nothing.
                const Coordinates<Real> free{c.x.data() + c.count, c.y.data() + c.count, c.z.data() + c.count};
                c.count += append_near({grid.x(), grid.y(), grid.z()}, row.begin, row.end, box, limit * Real(1 + 1e-6),
                                       free, c.slot.data() + c.count);
            }
        c.make_room(0);
        for (auto* array : {&c.x, &c.y, &c.z})
            std::fill_n(array->data() + c.count, PointGrid::kPadding, std::numeric_limits<Real>::infinity());
    };
    std::size_t used = 0;
    for (Index first = begin; first < end;) {
        const PointGrid::Cell cell = grid.cell_of(point(first));
        const Real most = std::numeric_limits<Real>::max();
        Around box{Vec3::Constant(most), Vec3::Constant(-most)};
        Index last = first;
        for (; last < end; ++last) {
            const Vec3 p = point(last);
            const PointGrid::Cell its = grid.cell_of(p);
            if (its.x != cell.x || its.y != cell.y || its.z != cell.z) break;
            if (!p.allFinite()) continue;  // has no neighbours
            box = {box.lower.cwiseMin(p), box.upper.cwiseMax(p)};
        }
        collect(cell, box);
        std::size_t self =
            static_cast<std::size_t>(std::lower_bound(c.slot.data(), c.slot.data() + c.count, first) - c.slot.data());
        for (Index slot = first; slot < last; ++slot) {
            const Index i = queries ? slot : grid.index(slot);
            if (i >= size()) {
                self += self < c.count && c.slot[self] == slot ? 1 : 0;
                continue;
            }
            if (scratch.indices.size() < used + c.count + PointGrid::kPadding)
                scratch.indices.resize(2 * used + c.count + PointGrid::kPadding);
            Index* out = scratch.indices.data() + used;
            const bool there = !queries && self < c.count && c.slot[self] == slot;
            const Real x = there ? c.x[self] : 0;
            if (there) c.x[self] = std::numeric_limits<Real>::infinity();  // a point is no neighbour of itself
            const std::size_t found =
                append_within({c.x.data(), c.y.data(), c.z.data()}, c.slot.data(), c.count, point(slot), limit, out);
            if (there) c.x[self++] = x;
            if (!grid.identity())
                for (std::size_t k = 0; k < found; ++k) out[k] = grid.index(out[k]);
            if (!block_.empty()) block_[i] = block;
            begin_[i] = static_cast<std::uint32_t>(used);
            count_[i] = static_cast<std::uint32_t>(found);
            used += found;
        }
        first = last;
    }
    std::vector<Index>& kept = blocks_[block];
    if (kept.capacity() < used) {
        kept = {};
        kept.reserve(used + used / 32);  // the lengths of lists vary little from step to step
    }
    kept.assign(scratch.indices.begin(), scratch.indices.begin() + static_cast<std::ptrdiff_t>(used));
}

std::size_t NeighbourLists::total() const {
    std::size_t sum = 0;
    for (const std::uint32_t n : count_) sum += n;
    return sum;
}

}  // namespace thixo
