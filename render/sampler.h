// Low-discrepancy sample values as a pure function of (seed, pixel, sample, dimension): order and threads cannot
// matter.
#pragma once

#include <bit>
#include <cstdint>

#include "pipeline/base/math.h"
#include "pipeline/base/random.h"

namespace thixo::render {

/// Owen-scrambled Sobol points, padded: every pair of dimensions is the (0,2)-sequence of Sobol's first two. Hashes of
/// pixel and pair shuffle its index and scramble its values (Burley 2020, "Practical hash-based Owen scrambling").
class Sampler {
  public:
    Sampler(std::uint64_t seed, std::uint32_t x, std::uint32_t y, std::uint32_t sample)
        : key_(mix64(mix64(seed) ^ (std::uint64_t(y) << 32 | x))), sample_(sample) {}

    float next() { return next2().x(); }

    Vec2f next2() {
        const std::uint64_t hash = mix64(key_ ^ ++pair_);
        const std::uint32_t a = std::uint32_t(hash), b = std::uint32_t(hash >> 32);
        const std::uint32_t index = scramble(sample_, a ^ 0x9e3779b9u);
        return {unit(scramble_reversed(index, a)), unit(scramble_reversed(sobol_y_reversed(index), b))};
    }

  private:
    /// Second dimension of the Sobol sequence with its bits reversed: the Pascal matrix modulo 2. Binomial (k, j) is
    /// odd where j has no bit that k has not (Lucas). So bit j is the parity of all index bits k that hold j.
    static std::uint32_t sobol_y_reversed(std::uint32_t v) {
        v ^= v >> 1 & 0x55555555u;
        v ^= v >> 2 & 0x33333333u;
        v ^= v >> 4 & 0x0f0f0f0fu;
        v ^= v >> 8 & 0x00ff00ffu;
        return v ^ (v >> 16);
    }
    static std::uint32_t reverse(std::uint32_t v) {
        v = (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
        v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
        v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
        return __builtin_bswap32(v);
    }
    /// Hash in which a bit depends on lower bits only (Laine & Karras 2011, constants of Vegdahl 2021): on reversed
    /// bits, Owen scrambling.
    static std::uint32_t permute(std::uint32_t v, std::uint32_t seed) {
        v ^= v * 0x3d20adeau;
        v += seed;
        v *= seed >> 16 | 1;
        v ^= v * 0x05526c56u;
        v ^= v * 0x53a22864u;
        return v;
    }
    static std::uint32_t scramble(std::uint32_t v, std::uint32_t seed) { return reverse(permute(reverse(v), seed)); }
    /// scramble(reverse(v)): the first dimension is the index with its bits reversed.
    static std::uint32_t scramble_reversed(std::uint32_t v, std::uint32_t seed) { return reverse(permute(v, seed)); }
    static float unit(std::uint32_t v) { return float(v >> 8) * 0x1.0p-24f; }

    std::uint64_t key_;
    std::uint32_t sample_;
    std::uint64_t pair_ = 0;
};

}  // namespace thixo::render
