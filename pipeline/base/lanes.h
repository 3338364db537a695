// Numbers side by side in one register. FloatLanes are eight floats in every build; Lanes are numbers of the state's
// type: eight floats, or four doubles in the double build. Sums over lanes have one fixed order.
#pragma once

#include <immintrin.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "pipeline/base/math.h"

namespace thixo {

/// Four scalars side by side, as a sweep packs them.
struct alignas(4 * sizeof(Real)) Quad {
    Real x, y, z, w;
};
inline Vec3 xyz(const Quad& q) { return {q.x, q.y, q.z}; }
inline Quad quad(const Vec3& v, Real w = 0) { return {v.x(), v.y(), v.z(), w}; }

inline constexpr int kFloatLanes = 8;
typedef float FloatLanes __attribute__((vector_size(32)));
/// What a comparison of FloatLanes gives: all bits set in the lanes where it holds.
typedef int LaneMask __attribute__((vector_size(32)));
typedef Index IndexLanes __attribute__((vector_size(32)));
/// Three coordinates and one number more.
typedef float FourFloats __attribute__((vector_size(16)));
inline FourFloats smaller(FourFloats a, FourFloats b) { return a < b ? a : b; }
inline FourFloats larger(FourFloats a, FourFloats b) { return a > b ? a : b; }

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

inline FloatLanes float_lanes(float a) { return _mm256_set1_ps(a); }
/// The sum of all lanes in the order ((0 + 4) + (2 + 6)) + ((1 + 5) + (3 + 7)). The compiler may fuse a product that
/// is summed here with the first addition: packed_sum, of the same order, then rounds otherwise.
inline float sum_of(FloatLanes a) { return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7])); }
/// The same by three packed additions.
inline float packed_sum(FloatLanes a) {
    const __m128 half = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    const __m128 quarter = _mm_add_ps(half, _mm_movehl_ps(half, half));
    return _mm_cvtss_f32(_mm_add_ss(quarter, _mm_shuffle_ps(quarter, quarter, 1)));
}
inline FloatLanes root(FloatLanes a) { return _mm256_sqrt_ps(a); }

/// a b + c, rounded once.
inline FloatLanes multiply_add(FloatLanes a, FloatLanes b, FloatLanes c) { return _mm256_fmadd_ps(a, b, c); }
/// a b - c, rounded once.
inline FloatLanes multiply_subtract(FloatLanes a, FloatLanes b, FloatLanes c) { return _mm256_fmsub_ps(a, b, c); }
/// c - a b, rounded once.
inline FloatLanes negative_multiply_add(FloatLanes a, FloatLanes b, FloatLanes c) { return _mm256_fnmadd_ps(a, b, c); }

/// Bit l is set where lane l of the mask is.
inline unsigned bits(LaneMask mask) { return unsigned(_mm256_movemask_ps(_mm256_castsi256_ps(__m256i(mask)))); }
/// The mask of bits().
inline LaneMask mask_of(unsigned lanes) {
    const LaneMask bit = {1, 2, 4, 8, 16, 32, 64, 128};
    return (bit & int(lanes)) == bit;
}
/// Least of the lanes whose bits are set; infinity where there is none.
inline float least(FloatLanes values, unsigned lanes) {
    const FloatLanes a = mask_of(lanes) ? values : float_lanes(std::numeric_limits<float>::infinity());
    const __m128 half = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    const __m128 quarter = _mm_min_ps(half, _mm_movehl_ps(half, half));
    return _mm_cvtss_f32(_mm_min_ss(quarter, _mm_shuffle_ps(quarter, quarter, 1)));
}
/// Lane k gets the sum over the lanes of a[k], pairs being added three times over.
inline FloatLanes sums_of_eight(const FloatLanes (&a)[8]) {
    const __m256 low = _mm256_hadd_ps(_mm256_hadd_ps(a[0], a[1]), _mm256_hadd_ps(a[2], a[3])),
                 high = _mm256_hadd_ps(_mm256_hadd_ps(a[4], a[5]), _mm256_hadd_ps(a[6], a[7]));
    return _mm256_add_ps(_mm256_permute2f128_ps(low, high, 0x20), _mm256_permute2f128_ps(low, high, 0x31));
}

#ifdef THIXO_DOUBLE

inline FloatLanes positive(FloatLanes a) { return a > 0 ? a : FloatLanes{}; }
inline FloatLanes load(const float* a) { return _mm256_loadu_ps(a); }

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
