// Files with the right checksum that no Thixo wrote: changed as chance has it, by a fixed seed, and sealed again.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

#include "pipeline/base/random.h"
#include "pipeline/contract/hash.h"

namespace thixo::test {

/// How many files a test tries: `few`, or what THIXO_FUZZ_ROUNDS says where somebody has an hour for it.
inline std::uint64_t fuzz_rounds(std::uint64_t few) {
    const char* asked = std::getenv("THIXO_FUZZ_ROUNDS");
    return asked ? std::strtoull(asked, nullptr, 10) : few;
}

/// One to three changes: bits, bytes, whole numbers, lengths; cut, grown, moved. A function of the seed and the round
/// alone.
inline std::string mutated(std::string bytes, std::uint64_t seed, std::uint64_t round) {
    using Limits32 = std::numeric_limits<std::int32_t>;
    constexpr std::array<std::int64_t, 12> kNumbers{0,
                                                    1,
                                                    -1,
                                                    2,
                                                    127,
                                                    255,
                                                    65535,
                                                    65536,
                                                    Limits32::max(),
                                                    Limits32::min(),
                                                    std::numeric_limits<std::int64_t>::max(),
                                                    std::numeric_limits<std::int64_t>::min()};
    const std::uint64_t edits = 1 + random_bits(seed, round, 0, 0) % 3;
    for (std::uint64_t k = 1; k <= edits; ++k) {
        const auto pick = [&](std::uint64_t use, std::size_t n) {
            return static_cast<std::size_t>(random_bits(seed, round, k, use) % std::max<std::size_t>(n, 1));
        };
        if (bytes.empty()) return bytes;
        const std::size_t at = pick(1, bytes.size());
        const auto put = [&](const void* value, std::size_t size) {
            std::memcpy(bytes.data() + at, value, std::min(size, bytes.size() - at));
        };
        switch (pick(0, 8)) {
            case 0:
                bytes[at] = static_cast<char>(bytes[at] ^ 1 << pick(2, 8));
                break;
            case 1:
                bytes[at] = static_cast<char>(pick(2, 256));
                break;
            case 2: {
                const auto number = static_cast<std::int32_t>(kNumbers[pick(2, kNumbers.size())]);
                put(&number, sizeof number);
                break;
            }
            case 3:
                put(&kNumbers[pick(2, kNumbers.size())], sizeof(std::int64_t));
                break;
            case 4: {  // a number a little larger or smaller
                std::int32_t number = 0;
                std::memcpy(&number, bytes.data() + at, std::min(sizeof number, bytes.size() - at));
                number = static_cast<std::int32_t>(static_cast<std::uint32_t>(number) + pick(2, 17) - 8);
                put(&number, sizeof number);
                break;
            }
            case 5:
                bytes.erase(at, 1 + pick(2, 64));
                break;
            case 6:
                bytes.insert(at, bytes.substr(pick(2, bytes.size()), 1 + pick(3, 64)));
                break;
            case 7: {
                const std::string other = bytes.substr(pick(2, bytes.size()), 1 + pick(3, 64));
                put(other.data(), other.size());
                break;
            }
        }
    }
    return bytes;
}

/// A text in which one to three of its numbers are others: zero, tiny, large, negative, none. What remains is well
/// formed, so that it gets further than most changes do. A function of the seed and the round alone.
inline std::string with_other_numbers(std::string text, std::uint64_t seed, std::uint64_t round) {
    constexpr std::array<std::string_view, 12> kNumbers{"0",   "-1",    "1",   "1e-30", "1e-6",  "0.001",
                                                        "0.3", "-0.05", "1e9", "1e30",  "1e999", "nan"};
    const auto digit = [](char c) { return c >= '0' && c <= '9'; };
    const auto part = [&](char c) { return digit(c) || c == '.' || c == '-' || c == '+' || c == 'e'; };
    const std::uint64_t edits = 1 + random_bits(seed, round, 0, 7) % 3;
    for (std::uint64_t k = 1; k <= edits; ++k) {
        // From a place of chance on, the next number; from the start again where there is none.
        std::size_t at = random_bits(seed, round, k, 8) % std::max<std::size_t>(text.size(), 1);
        at = text.find_first_of("0123456789", at);
        if (at == std::string::npos) at = text.find_first_of("0123456789");
        if (at == std::string::npos) return text;
        std::size_t begin = at, end = at;
        while (begin > 0 && part(text[begin - 1])) --begin;
        while (end < text.size() && part(text[end])) ++end;
        text.replace(begin, end - begin, kNumbers[random_bits(seed, round, k, 9) % kNumbers.size()]);
    }
    return text;
}

/// A PNG with the checksum of every chunk; what is too short for one stays.
inline std::string sealed_png(std::string bytes) {
    constexpr std::size_t kSignature = 8, kFrame = 12;  // of a chunk: length, type, checksum
    const auto byte = [&](std::size_t at) { return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at])); };
    for (std::size_t at = kSignature; at + kFrame <= bytes.size();) {
        const std::size_t length = byte(at) << 24 | byte(at + 1) << 16 | byte(at + 2) << 8 | byte(at + 3);
        if (length > bytes.size() - at - kFrame) return bytes;
        std::uint32_t crc = ~0u;
        for (std::size_t k = at + 4; k < at + 8 + length; ++k) {
            crc ^= byte(k);
            for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
        }
        for (int k = 0; k < 4; ++k) bytes[at + 8 + length + static_cast<std::size_t>(k)] = char(~crc >> (24 - 8 * k));
        at += kFrame + length;
    }
    return bytes;
}

/// A point file with the checksum in its header; what is too short for a header stays.
inline std::string sealed_points(std::string bytes) {
    constexpr std::size_t kAt = 21, kLength = 36;
    if (bytes.size() < kAt + kLength) return bytes;
    const std::string hash = hash_hex_without(bytes, kAt, kLength);
    const std::string_view h = hash;
    return bytes.replace(
        kAt, kLength,
        fmt::format("{}-{}-{}-{}-{}", h.substr(0, 8), h.substr(8, 4), h.substr(12, 4), h.substr(16, 4), h.substr(20)));
}

/// A manifest with its checksum, the first text of 32 digits; what has none stays.
inline std::string sealed_manifest(std::string text) {
    constexpr std::string_view kKey = "\"checksum\": \"";
    constexpr std::size_t kDigits = 32;
    const std::size_t at = text.find(kKey) + kKey.size();
    if (text.find(kKey) == std::string::npos || at + kDigits > text.size()) return text;
    return text.replace(at, kDigits, hash_hex_without(text, at, kDigits));
}

/// A file that ends with its checksum, as checkpoints do.
inline std::string sealed_tail(std::string bytes) {
    constexpr std::size_t kDigits = 32;
    bytes.resize(bytes.size() - std::min(kDigits, bytes.size()));
    return bytes + hash_hex(bytes);
}

}  // namespace thixo::test
