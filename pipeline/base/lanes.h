// Eight neighbours at a time (four in double): packed particles are gathered into lanes, and sums over lanes run in a
// fixed order.
#pragma once

#include <immintrin.h>

#include <cmath>
#include <cstring>

#include "pipeline/base/math.h"

namespace thixo {

/// Four scalars side by side, as a sweep packs them.
struct alignas(4 * sizeof(Real)) Quad {
    Real x, y, z, w;
};

inline constexpr std::size_t kLanes = 32 / sizeof(Real);
typedef Real Lanes __attribute__((vector_size(kLanes * sizeof(Real))));

inline Lanes all_lanes(Real a) { return Lanes{} + a; }
inline Lanes larger(Lanes a, Real b) { return a > b ? a : all_lanes(b); }
/// Lane l gets values[j[l]].
inline Lanes gather(const Real* values, const Index* j) {
    Lanes a;
    for (std::size_t l = 0; l < kLanes; ++l) a[l] = values[j[l]];
    return a;
}
inline Lanes positive(Lanes a) { return a > 0 ? a : Lanes{}; }
inline Lanes load(const Real* a) {
    Lanes out;
    std::memcpy(&out, a, sizeof out);
    return out;
}
inline void store(const Lanes& a, Real* to) { std::memcpy(to, &a, sizeof a); }
inline Lanes negative(Lanes a) { return a < 0 ? a : Lanes{}; }

#ifdef THIXO_DOUBLE

inline Real sum_of(Lanes a) { return (a[0] + a[2]) + (a[1] + a[3]); }
inline Lanes root(Lanes a) {
    for (std::size_t l = 0; l < kLanes; ++l) a[l] = std::sqrt(a[l]);
    return a;
}
inline void gather(const Quad* quads, const Index* j, Lanes& x, Lanes& y, Lanes& z, Lanes& w) {
    for (std::size_t l = 0; l < kLanes; ++l) {
        const Quad& q = quads[j[l]];
        x[l] = q.x;
        y[l] = q.y;
        z[l] = q.z;
        w[l] = q.w;
    }
}

#else

/// Adds pairs, always in the same order.
inline Real sum_of(Lanes a) { return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7])); }
inline Lanes root(Lanes a) { return _mm256_sqrt_ps(a); }

/// Lane l gets quads[j[l]], by eight loads of 16 bytes and a transposition.
inline void gather(const Quad* quads, const Index* j, Lanes& x, Lanes& y, Lanes& z, Lanes& w) {
    const auto pair = [&](int l) {
        return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(&quads[j[l]].x)),
                                    _mm_load_ps(&quads[j[l + 4]].x), 1);
    };
    const __m256 a = pair(0), b = pair(1), c = pair(2), d = pair(3);
    const __m256 ab = _mm256_unpacklo_ps(a, b), cd = _mm256_unpacklo_ps(c, d);  // x x y y
    const __m256 AB = _mm256_unpackhi_ps(a, b), CD = _mm256_unpackhi_ps(c, d);  // z z w w
    x = _mm256_shuffle_ps(ab, cd, 0x44);
    y = _mm256_shuffle_ps(ab, cd, 0xee);
    z = _mm256_shuffle_ps(AB, CD, 0x44);
    w = _mm256_shuffle_ps(AB, CD, 0xee);
}

#endif

/// The first n of kLanes indices, the rest `filler`.
inline void fill_up(const Index* list, std::size_t n, Index filler, Index* run) {
    for (std::size_t l = 0; l < kLanes; ++l) run[l] = l < n ? list[l] : filler;
}

/// Calls f(indices) for runs of kLanes neighbours. The last run is filled up with `filler`, which must add nothing to
/// what f sums.
template <class List, class F>
void for_each_run(const List& list, Index filler, F&& f) {
    const std::size_t n = list.size(), whole = n / kLanes * kLanes;
    for (std::size_t k = 0; k < whole; k += kLanes) f(list.data() + k);
    if (whole == n) return;
    alignas(32) Index last[kLanes];
    fill_up(list.data() + whole, n - whole, filler, last);
    f(static_cast<const Index*>(last));
}

}  // namespace thixo
