// Counter-based random numbers: a pure function of (seed, id, step, use), which no order or thread count can change.
#pragma once

#include <cstdint>

namespace thixo {

/// Finaliser of SplitMix64 (Steele, Lea & Flood 2014).
constexpr std::uint64_t mix64(std::uint64_t z) {
    z += 0x9e3779b97f4a7c15ull;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

/// 64 random bits for one use (a small constant named at the call) of element id in a step.
constexpr std::uint64_t random_bits(std::uint64_t seed, std::uint64_t id, std::uint64_t step, std::uint64_t use) {
    return mix64(mix64(mix64(mix64(seed) ^ id) ^ step) ^ use);
}

/// Uniform in [0, 1), 53 bits.
constexpr double random_unit(std::uint64_t seed, std::uint64_t id, std::uint64_t step, std::uint64_t use) {
    return static_cast<double>(random_bits(seed, id, step, use) >> 11) * 0x1.0p-53;
}

}  // namespace thixo
