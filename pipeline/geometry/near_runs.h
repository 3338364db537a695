// Visits the points of a grid around a place, kLanes at a time, directly from the grid's arrays, without lists.
#pragma once

#include <bit>
#include <limits>

#include "pipeline/base/lanes.h"
#include "pipeline/geometry/point_grid.h"

namespace thixo {

inline Lanes load_lanes(const Real* from) {
    Lanes a;
    __builtin_memcpy(&a, from, sizeof a);
    return a;
}

/// Whether any lane of a comparison holds.
template <class Mask>
bool any_lane(Mask mask) {
#ifdef THIXO_DOUBLE
    return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask)) != 0;
#else
    return _mm256_movemask_ps(reinterpret_cast<__m256>(mask)) != 0;
#endif
}

/// Calls f(slot, x, y, z, r2) for runs of slots with a point nearer than `radius` to p. It passes offsets from p and
/// squared distances. Lanes of points out of reach, and lanes past the end of a row, have offsets 0 and r2 = radius^2,
/// where kernels vanish. Requires radius <= grid.cell(). Arrays that f loads in slot order need PointGrid::kPadding
/// more places than points.
template <class F>
void for_each_near_run(const PointGrid& grid, const Vec3& p, Real radius, F&& f) {
    static_assert(PointGrid::kPadding >= kLanes);
    Lanes number;
    for (std::size_t l = 0; l < kLanes; ++l) number[l] = static_cast<Real>(l);
    const Lanes limit = all_lanes(radius * radius), none{};
    const PointGrid::Cell c = grid.cell_of(p);
    for (std::int32_t cz = c.z - 1; cz <= c.z + 1; ++cz)
        for (std::int32_t cy = c.y - 1; cy <= c.y + 1; ++cy) {
            const PointGrid::Range row = grid.row(c.x - 1, c.x + 1, cy, cz);
            for (Index slot = row.begin; slot < row.end; slot += kLanes) {
                const Lanes x = load_lanes(grid.x() + slot) - p.x(), y = load_lanes(grid.y() + slot) - p.y(),
                            z = load_lanes(grid.z() + slot) - p.z();
                const Lanes r2 = x * x + y * y + z * z;
                const auto near = (r2 < limit) & (number < static_cast<Real>(row.end - slot));
                if (!any_lane(near)) continue;
                f(slot, near ? x : none, near ? y : none, near ? z : none, near ? r2 : limit);
            }
        }
}

/// Calls f(l) for every lane l of a comparison that holds, ascending.
template <class Mask, class F>
void for_each_set_lane(Mask mask, F&& f) {
#ifdef THIXO_DOUBLE
    auto bits = static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
    auto bits = static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#endif
    for (; bits != 0; bits &= bits - 1) f(static_cast<Index>(std::countr_zero(bits)));
}

/// Calls f(slot, lanes, r2) for runs of slots with a point nearer than `radius` to p. The first `lanes` slots of a run
/// count. `radius` may exceed the cell.
template <class F>
void for_each_box_run(const PointGrid& grid, const Vec3& p, Real radius, F&& f) {
    const Real limit = radius * radius;
    const PointGrid::Cell a = grid.cell_of(p - Vec3::Constant(radius)), b = grid.cell_of(p + Vec3::Constant(radius));
    for (std::int32_t cz = a.z; cz <= b.z; ++cz)
        for (std::int32_t cy = a.y; cy <= b.y; ++cy) {
            const PointGrid::Range row = grid.row(a.x, b.x, cy, cz);
            for (Index slot = row.begin; slot < row.end; slot += kLanes) {
                const Lanes x = load_lanes(grid.x() + slot) - p.x(), y = load_lanes(grid.y() + slot) - p.y(),
                            z = load_lanes(grid.z() + slot) - p.z();
                const Lanes r2 = x * x + y * y + z * z;
                if (any_lane(r2 < all_lanes(limit))) f(slot, std::min<Index>(kLanes, row.end - slot), r2);
            }
        }
}

/// Calls f(slot, r2) for every point nearer than `radius` to p. `radius` may exceed the cell.
template <class F>
void for_each_in_box(const PointGrid& grid, const Vec3& p, Real radius, F&& f) {
    const Real limit = radius * radius;
    for_each_box_run(grid, p, radius, [&](Index slot, Index lanes, Lanes r2) {
        for (Index l = 0; l < lanes; ++l)
            if (r2[l] < limit) f(slot + l, r2[l]);
    });
}

}  // namespace thixo
