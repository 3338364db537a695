// Eight lanes of floats: masks and reductions.
#pragma once

#include <immintrin.h>

#include <limits>

namespace thixo::render {

inline unsigned bits(__m256 mask) { return unsigned(_mm256_movemask_ps(mask)); }

/// All bits set in the lanes of `lanes`.
inline __m256 mask_of(unsigned lanes) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(int(lanes)), bit), bit));
}

inline float sum(__m256 a) {
    const __m128 half = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    const __m128 quarter = _mm_add_ps(half, _mm_movehl_ps(half, half));
    return _mm_cvtss_f32(_mm_add_ss(quarter, _mm_shuffle_ps(quarter, quarter, 1)));
}

/// Least of the chosen lanes; infinity where there is none.
inline float least(__m256 values, unsigned lanes) {
    const __m256 v = _mm256_blendv_ps(_mm256_set1_ps(std::numeric_limits<float>::infinity()), values, mask_of(lanes));
    const __m128 half = _mm_min_ps(_mm256_castps256_ps128(v), _mm256_extractf128_ps(v, 1));
    const __m128 quarter = _mm_min_ps(half, _mm_movehl_ps(half, half));
    return _mm_cvtss_f32(_mm_min_ss(quarter, _mm_shuffle_ps(quarter, quarter, 1)));
}

}  // namespace thixo::render
