#include "pipeline/geometry/neighbour_lists.h"

#include <immintrin.h>

#include <array>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"

namespace thixo {
namespace {

// Row m lists the lanes set in the 8-bit mask m, in order: a permutation that moves them to the front.
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

/// Appends candidate[k] for every k < n with |(x, y, z)_k - p|^2 < limit to `out`, in order; returns how many. Reads
/// and writes up to 7 places past the end. The arrays' unused places hold infinity.
[[maybe_unused]] std::size_t append_within(const float* x, const float* y, const float* z, const Index* candidate,
                                           std::size_t n, const Vec3f& p, float limit, Index* out) {
    const __m256 px = _mm256_set1_ps(p.x()), py = _mm256_set1_ps(p.y()), pz = _mm256_set1_ps(p.z()),
                 l2 = _mm256_set1_ps(limit);
    std::size_t found = 0;
    for (std::size_t k = 0; k < n; k += 8) {
        const __m256 dx = _mm256_sub_ps(_mm256_loadu_ps(x + k), px);
        const __m256 dy = _mm256_sub_ps(_mm256_loadu_ps(y + k), py);
        const __m256 dz = _mm256_sub_ps(_mm256_loadu_ps(z + k), pz);
        const __m256 r2 = _mm256_fmadd_ps(dz, dz, _mm256_fmadd_ps(dy, dy, _mm256_mul_ps(dx, dx)));
        const auto mask = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(r2, l2, _CMP_LT_OQ)));
        const __m256i lanes = _mm256_load_si256(reinterpret_cast<const __m256i*>(kFrontLanes[mask].data()));
        const __m256i ids = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(candidate + k));
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + found), _mm256_permutevar8x32_epi32(ids, lanes));
        found += static_cast<std::size_t>(__builtin_popcount(mask));
    }
    return found;
}

[[maybe_unused]] std::size_t append_within(const double* x, const double* y, const double* z, const Index* candidate,
                                           std::size_t n, const Vec3d& p, double limit, Index* out) {
    std::size_t found = 0;
    for (std::size_t k = 0; k < n; ++k) {
        out[found] = candidate[k];
        found += square(x[k] - p.x()) + square(y[k] - p.y()) + square(z[k] - p.z()) < limit ? 1 : 0;
    }
    return found;
}

}  // namespace

void NeighbourLists::resize(std::size_t lists, std::size_t places) {
    block_.resize(lists);
    begin_.resize(lists);
    count_.resize(lists);
    blocks_.resize((places + kChunk - 1) / kChunk);
}

void NeighbourLists::build(const PointGrid& grid, Real radius, std::size_t count) {
    THIXO_ASSERT(radius <= grid.cell(), "radius {} exceeds the cell {}", radius, grid.cell());
    resize(std::min(count, grid.size()), grid.size());
    parallel_chunks(grid.size(), [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        fill(grid, nullptr, radius, static_cast<Index>(begin), static_cast<Index>(end),
             static_cast<std::uint32_t>(chunk));
    });
}

void NeighbourLists::build(const PointGrid& grid, std::span<const Vec3> queries, Real radius) {
    THIXO_ASSERT(radius <= grid.cell(), "radius {} exceeds the cell {}", radius, grid.cell());
    resize(queries.size(), queries.size());
    parallel_chunks(queries.size(), [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        fill(grid, queries.data(), radius, static_cast<Index>(begin), static_cast<Index>(end),
             static_cast<std::uint32_t>(chunk));
    });
}

/// Puts the points of the 27 cells around `cell` side by side.
void NeighbourLists::collect(Block& b, const PointGrid& grid, const PointGrid::Cell& cell, std::size_t& candidates) {
    candidates = 0;
    for (std::int32_t z = cell.z - 1; z <= cell.z + 1; ++z)
        for (std::int32_t y = cell.y - 1; y <= cell.y + 1; ++y) {
            const auto range = grid.row(cell.x - 1, cell.x + 1, y, z);
            const std::size_t n = range.end - range.begin;
            if (b.candidate.size() < candidates + n + PointGrid::kPadding) {
                const std::size_t room = 2 * (candidates + n) + PointGrid::kPadding;
                for (auto* array : {&b.x, &b.y, &b.z}) array->resize(room);
                b.candidate.resize(room);
            }
            std::copy_n(grid.x() + range.begin, n, b.x.data() + candidates);
            std::copy_n(grid.y() + range.begin, n, b.y.data() + candidates);
            std::copy_n(grid.z() + range.begin, n, b.z.data() + candidates);
            for (std::size_t k = 0; k < n; ++k) b.candidate[candidates + k] = range.begin + static_cast<Index>(k);
            candidates += n;
        }
    if (b.x.size() < candidates + PointGrid::kPadding) {
        for (auto* array : {&b.x, &b.y, &b.z}) array->resize(candidates + PointGrid::kPadding);
        b.candidate.resize(candidates + PointGrid::kPadding);
    }
    std::fill_n(b.x.data() + candidates, PointGrid::kPadding, std::numeric_limits<Real>::infinity());
}

/// Lists of the slots (or queries) begin..end - 1.
void NeighbourLists::fill(const PointGrid& grid, const Vec3* queries, Real radius, Index begin, Index end,
                          std::uint32_t block) {
    Block& b = blocks_[block];
    const Real limit = radius * radius;
    std::size_t used = 0, candidates = 0;
    PointGrid::Cell present{0, 0, 0};
    bool collected = false;
    for (Index s = begin; s < end; ++s) {
        const Index i = queries ? s : grid.index(s);
        if (i >= size()) continue;
        const Vec3 p = queries ? queries[s] : Vec3(grid.x()[s], grid.y()[s], grid.z()[s]);
        const PointGrid::Cell cell = grid.cell_of(p);
        if (!collected || cell.x != present.x || cell.y != present.y || cell.z != present.z) {
            collected = true;
            present = cell;
            collect(b, grid, cell, candidates);  // shared by all that follow in the same cell
        }
        if (b.indices.size() < used + candidates + PointGrid::kPadding)
            b.indices.resize(2 * used + candidates + PointGrid::kPadding);
        Index* out = b.indices.data() + used;
        std::size_t found =
            append_within(b.x.data(), b.y.data(), b.z.data(), b.candidate.data(), candidates, p, limit, out);
        Index* self = queries ? out + found : std::find(out, out + found, s);
        if (self != out + found) {
            std::copy(self + 1, out + found, self);
            --found;
        }
        if (!grid.identity())
            for (std::size_t k = 0; k < found; ++k) out[k] = grid.index(out[k]);
        block_[i] = block;
        begin_[i] = static_cast<std::uint32_t>(used);
        count_[i] = static_cast<std::uint32_t>(found);
        used += found;
    }
}

std::size_t NeighbourLists::total() const {
    std::size_t sum = 0;
    for (const std::uint32_t n : count_) sum += n;
    return sum;
}

}  // namespace thixo
